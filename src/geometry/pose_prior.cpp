#include "corrsel/pose_prior.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "geometry/checked_matrix.h"

namespace corrsel::core {
namespace {

/// A direction of length 1; what has no length stays as it is, for check() to name it.
cv::Vec3d directionOf(const cv::Vec3d& vector) {
  const double length = cv::norm(vector);
  return length > 0 && std::isfinite(length) ? vector / length : vector;
}

}  // namespace

PosePrior PosePrior::ofRotation(const cv::Matx33d& rotation) {
  PosePrior prior;
  prior.kind = Kind::kRotation;
  prior.rotation = rotation;
  return prior;
}

PosePrior PosePrior::ofVertical(const cv::Vec3d& left_down, const cv::Vec3d& right_down) {
  PosePrior prior;
  prior.kind = Kind::kVertical;
  prior.left_down = directionOf(left_down);
  prior.right_down = directionOf(right_down);
  return prior;
}

PosePrior PosePrior::ofRig(const cv::Matx33d& rotation, const cv::Vec3d& translation) {
  PosePrior prior;
  prior.kind = Kind::kRig;
  prior.rotation = rotation;
  prior.translation = directionOf(translation);
  return prior;
}

void PosePrior::check() const {
  switch (kind) {
    case Kind::kRotation:
      requireRotation("rotation", rotation);
      return;
    case Kind::kVertical:
      requireDirection("left_down", left_down);
      requireDirection("right_down", right_down);
      return;
    case Kind::kRig:
      requireRotation("rotation", rotation);
      requireDirection("translation", translation);
      return;
  }
  throw std::invalid_argument("kind = " + std::to_string(static_cast<int>(kind)) +
                              " does not exist; valid: 0 to 2");
}

}  // namespace corrsel::core
