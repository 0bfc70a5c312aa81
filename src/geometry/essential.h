#pragma once

#include <cstddef>
#include <opencv2/core/matx.hpp>
#include <optional>

#include "corrsel/pose_prior.h"
#include "corrsel/pose_result.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// E = [t]_x R; d'^T E d = 0 for the rays of a match.
cv::Matx33d essentialOf(const Pose& pose);

/// The four poses with the essential matrix E, of any scale: both rotations, each with +t and -t, in the
/// order (R1, t), (R1, -t), (R2, t), (R2, -t). Without a singular value decomposition: t t^T = trace(E E^T)/2
/// I - E E^T, R = (cof(E) -+ [t]_x E) / |t|^2 (Horn, Recovering baseline and orientation from essential
/// matrix, 1990).
/// @return false if E is 0 or not finite
bool posesOf(const cv::Matx33d& essential, Pose (&poses)[4]);

/// Depths of the point of a match along both rays, times sin^2 of the angle between them.
struct ScaledDepths {
  double left, right;
};
ScaledDepths scaledDepths(const Pose& pose, const cv::Vec3d& left, const cv::Vec3d& right);

/// Whether match i lies in front of both cameras: both scaled depths above -threshold times the pixel angles
/// of both rays, because the sign of a far point's depth is noise.
/// @param threshold  px
bool isInFront(const Pose& pose, const RayMatches& matches, std::size_t i, double threshold);

/// Signed tangent Sampson error of match i, px: r = C / sqrt(|J1^T m|^2 + |J2^T l|^2) with l = E d1,
/// m = E^T d2, C = d2 . l. 0 where both gradients vanish, as at the epipoles. For pinholes without distortion
/// |r| is the Sampson distance in pixels but for a share of about r over the focal length.
/// (Terekhov and Larsson, Tangent Sampson error, ICCV 2023)
double tangentSampson(const cv::Matx33d& essential, const RayMatches& matches, std::size_t i);

/// Squared tangent Sampson errors of all matches, px^2; NaN where a ray is NaN.
void squaredTangentSampson(const cv::Matx33d& essential, const RayMatches& matches, double* out);

/// Chooses among the four poses with this essential matrix the one that has most of the first 100 matches
/// with an error of at most the threshold strictly in front of both cameras.
/// @param prior  poses that differ from it are left out, and the pose keeps to it exactly
/// @return false if less than half of them are in front under the best pose, or none agrees
bool choosePose(const cv::Matx33d& essential, const RayMatches& matches, double threshold, Pose& pose,
                const std::optional<PosePrior>& prior = std::nullopt);

}  // namespace corrsel::core
