#include "corrsel/evaluation/errors.h"

#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/essential.h"
#include "geometry/fundamental.h"
#include "geometry/homography.h"
#include "geometry/rays.h"

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

/// The homography for which the centre of the left image, or of the matches where its size is unknown, has a
/// positive third coordinate.
cv::Matx33d oriented(const cv::Matx33d& h, const Correspondences& matches) {
  double x = 0.5 * matches.left_size.width, y = 0.5 * matches.left_size.height;
  if (matches.left_size.empty()) {
    x = y = 0;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      if (!std::isfinite(matches.left_x[i]) || !std::isfinite(matches.left_y[i])) continue;
      x += matches.left_x[i] / static_cast<double>(matches.size());
      y += matches.left_y[i] / static_cast<double>(matches.size());
    }
  }
  return inFront(h, x, y);
}

/// The errors against a truth of rays.
std::vector<double> rayErrors(const GroundTruth& truth, const Correspondences& matches) {
  if (!matches.left_camera || !matches.right_camera) {
    throw std::invalid_argument("the ground truth is of the kind " + toString(truth.kind) +
                                ", and the matches have no cameras; give both cameras");
  }
  RayMatches rays;
  std::vector<std::uint8_t> exists;
  unproject(matches, rays, exists);
  std::vector<double> errors(matches.size());
  if (truth.kind == TruthKind::kEssential) {
    squaredTangentSampson(truth.matrix, rays, errors.data());
    for (double& error : errors) error = std::sqrt(error);
  } else {
    for (std::size_t i = 0; i < errors.size(); ++i) {
      const cv::Vec3d turned = truth.matrix * rays.left.direction(i), right = rays.right.direction(i);
      errors[i] = std::atan2(cv::norm(turned.cross(right)), turned.dot(right)) / rays.right.pixelAngle(i);
    }
  }
  for (std::size_t i = 0; i < errors.size(); ++i) {
    if (exists[i] == 0) errors[i] = std::numeric_limits<double>::infinity();
  }
  return errors;
}

}  // namespace

std::vector<double> groundTruthErrors(const GroundTruth& truth, const Correspondences& matches) {
  const std::size_t n = matches.size();
  if (truth.kind == TruthKind::kLabels && truth.labels.size() != n) {
    throw std::invalid_argument("ground truth has " + std::to_string(truth.labels.size()) + " labels for " +
                                std::to_string(n) + " matches");
  }
  if (truth.kind == TruthKind::kEssential || truth.kind == TruthKind::kRotation) {
    return rayErrors(truth, matches);
  }
  std::vector<double> errors(n, kUnknown);
  const cv::Matx33d homography = oriented(truth.matrix, matches);
  for (std::size_t i = 0; i < n; ++i) {
    const float lx = matches.left_x[i], ly = matches.left_y[i], rx = matches.right_x[i],
                ry = matches.right_y[i];
    const bool finite = std::isfinite(lx) && std::isfinite(ly) && std::isfinite(rx) && std::isfinite(ry);
    if (!finite && truth.kind != TruthKind::kNone && truth.kind != TruthKind::kLabels) {
      errors[i] = std::numeric_limits<double>::infinity();
      continue;
    }
    switch (truth.kind) {
      case TruthKind::kNone:
      case TruthKind::kEssential:
      case TruthKind::kRotation:
        break;
      case TruthKind::kHomography:
        errors[i] = std::sqrt(homographyError(homography, lx, ly, rx, ry));
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
