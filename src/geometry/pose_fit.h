#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/pose_result.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// Sums over matches of what one step of the refinement needs; r is the tangent Sampson error, px, and J its
/// derivative by the five parameters (order of PoseResult::covariance).
struct PoseSums {
  double cost = 0;                 ///< sum of r^2 / (1 + r^2 / c^2), px^2
  cv::Vec<double, 5> gradient;     ///< sum of w r J, w = 1 / (1 + r^2 / c^2)^2
  cv::Matx<double, 5, 5> hessian;  ///< sum of w J J^T
};

/// @param scale  c of the Geman-McClure loss, px; infinity = least squares
PoseSums poseSums(const Pose& pose, const RayMatches& matches, double scale);

/// Minimises the Geman-McClure loss of the tangent Sampson errors of all given matches by Levenberg and
/// Marquardt's method: lambda 1e-3, times 0.1 or 10. Restores the sign of t by the majority of depths, which
/// the loss does not see.
/// @param matches  that take part; at least 5
/// @param steps    at most
/// @return the loss at the end, px^2; NaN if the normal equations are degenerate (the pose is unchanged)
double fitPose(const RayMatches& matches, double scale, int steps, Pose& pose);

/// One step of the parameters: exp([w]_x) R, and the direction of t + a b1 + b b2.
Pose moved(const Pose& pose, const cv::Vec<double, 5>& step);

/// Covariance of a fitted pose (order of PoseResult::covariance) by the sandwich of the Geman-McClure loss:
/// (mean psi^2 / (mean psi')^2) n/(n-5) (sum J J^T)^-1.
/// @return false if there are fewer than 6 matches or the condition of sum J J^T exceeds 1e12
bool poseCovariance(const Pose& pose, const RayMatches& matches, double scale,
                    cv::Matx<double, 5, 5>& covariance);

/// The two poses that a homography between unit rays, H ~ R + t n^T, allows for a plane (Malis and Vargas,
/// RR-6303, 2007; here by the eigenvectors of H^T H). t has length 1, n points to the plane from the left
/// camera: each pose and normal occurs once, with the sign of t for which most of the matches are in front.
struct PlanePose {
  Pose pose;
  cv::Vec3d normal;
};
/// @return false if H has no inverse, or differs from a rotation by less than 1e-9
bool posesOfPlane(const cv::Matx33d& homography, const RayMatches& matches, PlanePose (&poses)[2]);

}  // namespace corrsel::core
