#include "corrsel/evaluation/errors.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "corrsel/geometry/fundamental.h"
#include "corrsel/geometry/homography.h"

namespace corrsel::core {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// Disparity at a sub-pixel position: that of the nearest pixel, since interpolation would mix depths at
/// edges.
double disparityAt(const cv::Mat& disparity, float x, float y) {
  if (!(x >= 0 && y >= 0 && x <= static_cast<float>(disparity.cols - 1) &&
        y <= static_cast<float>(disparity.rows - 1))) {
    return kUnknown;
  }
  return disparity.at<float>(static_cast<int>(std::lround(y)), static_cast<int>(std::lround(x)));
}

}  // namespace

std::vector<double> groundTruthErrors(const GroundTruth& truth, const Correspondences& matches) {
  const std::size_t n = matches.size();
  if (truth.kind == TruthKind::kLabels && truth.labels.size() != n) {
    throw std::invalid_argument("ground truth has " + std::to_string(truth.labels.size()) + " labels for " +
                                std::to_string(n) + " matches");
  }
  std::vector<double> errors(n, kUnknown);
  for (std::size_t i = 0; i < n; ++i) {
    const float lx = matches.left_x[i], ly = matches.left_y[i], rx = matches.right_x[i],
                ry = matches.right_y[i];
    switch (truth.kind) {
      case TruthKind::kNone:
        break;
      case TruthKind::kHomography:
        errors[i] = std::sqrt(homographyError(truth.matrix, lx, ly, rx, ry));
        break;
      case TruthKind::kFundamental:
        errors[i] = epipolarLineDistance(truth.matrix, lx, ly, rx, ry);
        break;
      case TruthKind::kLabels:
        errors[i] = truth.labels[i] > 0 ? 0.0 : std::numeric_limits<double>::infinity();
        break;
      case TruthKind::kDisparity:
        errors[i] = std::hypot(lx - disparityAt(truth.disparity, lx, ly) - rx, static_cast<double>(ly) - ry);
        break;
    }
  }
  return errors;
}

}  // namespace corrsel::core
