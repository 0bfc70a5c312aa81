#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/evaluation/statistics.h"
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
