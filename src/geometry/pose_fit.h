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

/// The directions in which a fit may move the five parameters, each a combination of them. Directions that
/// are left out are known and stay as they are.
struct PoseFreedom {
  int size = 0;
  cv::Vec<double, 5> directions[5];

  static PoseFreedom all();
  /// The translation; the rotation is known.
  static PoseFreedom translation();
  /// The translation and the angle about a known axis, for example the vertical.
  /// @param axis  of length 1, in the frame of the right camera
  static PoseFreedom about(const cv::Vec3d& axis);
};

/// @param scale  c of the Geman-McClure loss, px; infinity = least squares
PoseSums poseSums(const Pose& pose, const RayMatches& matches, double scale);

/// Minimises the Geman-McClure loss of the tangent Sampson errors of all given matches by Levenberg and
/// Marquardt's method: lambda 1e-3, times 0.1 or 10. Restores the sign of t by the majority of depths, which
/// the loss does not see.
/// @param matches  that take part; at least as many as there are directions of freedom
/// @param steps    at most; fewer are taken once they lower the loss by less than 1e-9 of it
/// @return the loss at the end, px^2; NaN if the normal equations are degenerate (the pose is unchanged)
double fitPose(const RayMatches& matches, double scale, int steps, Pose& pose,
               const PoseFreedom& freedom = PoseFreedom::all());

/// One step of the parameters: exp([w]_x) R, and the direction of t + a b1 + b b2.
Pose moved(const Pose& pose, const cv::Vec<double, 5>& step);

/// Covariance of a fitted pose (order of PoseResult::covariance) by the sandwich of the Geman-McClure loss:
/// K^2 (mean psi^2 / (mean psi')^2) n/(n-k) (sum J J^T)^-1 in the k directions of freedom, 0 across them,
/// with K = 1 + k/n var(psi') / (mean psi')^2 (Huber, Robust Statistics, 1981, section 7.6), psi = r /
/// (1+x)^2, psi' = (1-3x) / (1+x)^3, x = r^2 / c^2.
/// @return false if there are at most k matches or the condition of sum J J^T exceeds 1e12
bool poseCovariance(const Pose& pose, const RayMatches& matches, double scale,
                    cv::Matx<double, 5, 5>& covariance, const PoseFreedom& freedom = PoseFreedom::all());

/// The two poses that a homography between unit rays, H ~ R + t n^T, allows for a plane (Malis and Vargas,
/// RR-6303, 2007; here by the eigenvectors of H^T H). t has length 1, n is as long as makes R + t n^T equal
/// to H but for a factor. Of the signs of (t, n) the one is returned with which most of the matches lie
/// before the cameras. Where the camera moved along the normal, both poses are the same.
struct PlanePose {
  Pose pose;
  cv::Vec3d normal;  ///< n of the plane n . X = 1, X in units of the baseline and in the left camera's frame
};
/// @param homography  of any scale and sign
/// @return false if H has no inverse, or differs from a rotation by less than 1e-9
bool posesOfPlane(const cv::Matx33d& homography, const RayMatches& matches, PlanePose (&poses)[2]);

}  // namespace corrsel::core
