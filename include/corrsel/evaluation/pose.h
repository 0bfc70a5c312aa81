#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/pose_result.h"
#include "corrsel/relative_pose.h"

namespace corrsel::core {

/// What counts as the error of a pair whose pose could not be estimated, degrees.
inline constexpr double kFailedPose = 180.0;

/// Thresholds of the areas under the curve and of the mean average accuracy.
inline const std::vector<double> kPoseThresholds = {5, 10, 20};                          ///< degrees
inline const std::vector<double> kCornerThresholds = {1, 3, 5};                          ///< px
inline const std::vector<double> kAccuracyThresholds = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10};  ///< degrees or px

/// Bound of the squared epipolar distance of a correct match, in normalised coordinates (LoFTR, Sun et al.,
/// CVPR 2021).
inline constexpr double kEpipolarThreshold = 1e-4;

/// How far an estimated pose is from the true one.
struct PoseErrors {
  double rotation = kUndefined;     ///< angle of the rotation between both, degrees, 0 to 180
  double translation = kUndefined;  ///< angle between both lines of direction, degrees, 0 to 90; NaN where
                                    ///< one of the two translations is zero
  double pose = kFailedPose;        ///< the larger one of those that are defined, degrees
};

/// Compares an estimated pose with the true one as the field does (SuperGlue, Sarlin et al., CVPR 2020). The
/// length of a translation cannot be estimated from two images. Its sign is not compared either: an angle
/// above 90 degrees counts as 180 degrees less the angle. Where the true camera only turned, the pose error
/// is the rotation error; where only the estimated translation is zero, it is kFailedPose.
PoseErrors poseErrors(const cv::Matx33d& rotation, const cv::Vec3d& translation, const RelativePose& truth);

/// The error of an estimated pose in the parameters of PoseResult::covariance: w, rad, with R_true =
/// exp([w]_x) R; and a and b, rad, the components along translationBasis() of the rotation that turns t into
/// the true direction. To first order, the true direction is that of t + a b1 + b b2. a and b are NaN where
/// one of the translations is 0.
cv::Vec<double, 5> poseDeviation(const Pose& estimate, const RelativePose& truth);

/// How far an estimated pose is from the true one, measured by the covariance that was given with it.
struct NormalizedError {
  double squared = kUndefined;  ///< e^T C^-1 e; its mean is the number of degrees of freedom if C is right
  std::size_t degrees = 0;      ///< of freedom: 5, of a rotation 3; 0 where the error is undefined

  /// Whether the true pose lies inside the ellipsoid that should hold 95 % of them.
  bool inside() const;
};

/// Normalised estimation error squared, NEES (Bar-Shalom, Li and Kirubarajan, Estimation with Applications to
/// Tracking and Navigation, 2001, Eq. 5.4.2-1). The rotation alone is compared where neither the estimate nor
/// the truth has a translation. It is undefined where only one of them has, and where the covariance is not
/// given (NaN) or is not positive definite.
NormalizedError normalizedError(const PoseResult& estimate, const RelativePose& truth);

/// 95 % quantiles of the chi-squared distribution.
inline constexpr double kChiSquared5 = 11.0705;  ///< with 5 degrees of freedom
inline constexpr double kChiSquared3 = 7.8147;   ///< with 3

/// How the right camera moved, as far as a pose tells: kRest (neither turned nor translated, to 1e-9),
/// kRotation or kGeneral.
Motion trueMotion(const RelativePose& truth);

/// Area under the curve of recall against error up to `threshold`, divided by the threshold: 0 to 1. The
/// curve connects the points (error i, i / N) of the sorted errors by straight lines, begins at the origin,
/// and is constant from the last error below the threshold on (pose_auc() of SuperGlue, Sarlin et al., CVPR
/// 2020).
/// @param errors  of all pairs, those of failed pairs included (kFailedPose or +Inf); NaN is not allowed
/// NaN for no errors. Throws std::invalid_argument for a NaN or negative error and for a threshold that is
/// not above 0. O(N log N).
double errorAuc(std::vector<double> errors, double threshold);

/// 95 % percentile bootstrap interval of errorAuc(), resampled over pairs, see bootstrapMean().
/// @param pairs  the errors of the repetitions of each pair
/// Throws std::invalid_argument like errorAuc(). O(resamples * errors).
Interval bootstrapAuc(const std::vector<std::vector<double>>& pairs, double threshold, std::uint64_t seed,
                      int resamples = kBootstrapResamples);

/// Share of `thresholds` that the error is below: 0 to 1. Its mean over the pairs is the mean average
/// accuracy (mAA) of the Image Matching Benchmark (Jin et al., IJCV 2021), whose thresholds are 1 to 10
/// degrees.
double thresholdAccuracy(double error, const std::vector<double>& thresholds = kAccuracyThresholds);

/// Squared symmetric epipolar distance of every match in normalised coordinates: the sum of the squared
/// distances of both points from their epipolar lines (Hartley and Zisserman, Eq. 11.10; SuperGlue's
/// compute_epipolar_error()). +Inf where a coordinate is not finite or a point is the epipole. Throws
/// std::invalid_argument where the true translation is zero. O(N).
std::vector<double> epipolarErrors(const RelativePose& truth, const Correspondences& matches);

/// Share of the selected matches with epipolarErrors() below `threshold`; 0 where nothing is selected, as in
/// SuperGlue's evaluation.
/// @param mask  as long as errors; throws std::invalid_argument otherwise
double epipolarPrecision(const std::vector<double>& errors, const std::vector<std::uint8_t>& mask,
                         double threshold = kEpipolarThreshold);

/// Mean distance between the corners of the left image, as the estimated and as the true homography project
/// them, px (SuperPoint, DeTone et al., CVPRW 2018). The corners are the centres of the corner pixels. The
/// signs of both matrices are chosen so that the centre of the image has a positive third coordinate. +Inf
/// where the estimate puts a corner behind the camera that the truth does not. Throws std::invalid_argument
/// for an empty size.
double cornerError(const cv::Matx33d& homography, const cv::Matx33d& truth, const cv::Size& left_size);

}  // namespace corrsel::core
