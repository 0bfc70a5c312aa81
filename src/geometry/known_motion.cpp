#include "geometry/known_motion.h"

#include "corrsel/pose_result.h"
#include "geometry/cross_matrix.h"

namespace corrsel::core {
namespace {

constexpr double kMinCosine = 1e-12;  // plus 1, of directions that are not opposite

/// The smallest turn that takes one direction to another.
cv::Matx33d turnBetween(const cv::Vec3d& from, const cv::Vec3d& to) {
  const double cosine_plus_one = 1 + from.dot(to);
  if (cosine_plus_one < kMinCosine) {
    cv::Vec3d axis, other;
    translationBasis(from, axis, other);
    return axis * axis.t() * 2 - cv::Matx33d::eye();
  }
  const cv::Matx33d cross = crossMatrix(from.cross(to));
  return cv::Matx33d::eye() + cross + cross * cross * (1 / cosine_plus_one);
}

}  // namespace

cv::Matx33d constrained(const std::optional<PosePrior>& prior, const cv::Matx33d& rotation) {
  if (!prior) return rotation;
  if (prior->kind != PosePrior::Kind::kVertical) return prior->rotation;
  return turnBetween(rotation * prior->left_down, prior->right_down) * rotation;
}

PoseFreedom freedomOf(const std::optional<PosePrior>& prior) {
  if (!prior) return PoseFreedom::all();
  switch (prior->kind) {
    case PosePrior::Kind::kRotation:
      return PoseFreedom::translation();
    case PosePrior::Kind::kVertical:
      return PoseFreedom::about(prior->right_down);
    case PosePrior::Kind::kRig:
      break;
  }
  return {};
}

}  // namespace corrsel::core
