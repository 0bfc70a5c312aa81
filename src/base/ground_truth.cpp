#include "corrsel/ground_truth.h"

#include <stdexcept>

namespace corrsel::core {

std::string toString(TruthKind kind) {
  switch (kind) {
    case TruthKind::kNone:
      return "none";
    case TruthKind::kHomography:
      return "homography";
    case TruthKind::kFundamental:
      return "fundamental";
    case TruthKind::kLabels:
      return "labels";
    case TruthKind::kDisparity:
      return "disparity";
  }
  throw std::invalid_argument("unknown ground truth kind " + std::to_string(static_cast<int>(kind)));
}

}  // namespace corrsel::core
