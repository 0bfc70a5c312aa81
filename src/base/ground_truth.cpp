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
    case TruthKind::kEssential:
      return "essential";
    case TruthKind::kRotation:
      return "rotation";
  }
  throw std::invalid_argument("unknown ground truth kind " + std::to_string(static_cast<int>(kind)));
}

TruthKind truthKindFromString(const std::string& text) {
  std::string valid;
  for (const TruthKind kind :
       {TruthKind::kNone, TruthKind::kHomography, TruthKind::kFundamental, TruthKind::kLabels,
        TruthKind::kDisparity, TruthKind::kEssential, TruthKind::kRotation}) {
    if (toString(kind) == text) return kind;
    valid += (valid.empty() ? "" : ", ") + toString(kind);
  }
  throw std::invalid_argument("'" + text + "' is no kind of ground truth; valid: " + valid);
}

}  // namespace corrsel::core
