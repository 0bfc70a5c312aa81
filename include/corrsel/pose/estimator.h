#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>

#include "corrsel/correspondences.h"
#include "corrsel/relative_pose.h"

namespace corrsel::core {

/// The estimators below are those of the evaluation, in the library corrsel::benchmark. They are the same for
/// every selector, so that what differs is the selection; these constants are no options for the same reason.
/// Both use OpenCV's RANSAC, whose random numbers have a fixed seed.
inline constexpr double kPoseThreshold = 1.0;        ///< of RANSAC, px; divided by the mean focal length
inline constexpr double kPoseConfidence = 0.99999;   ///< of RANSAC, as in SuperGlue's evaluation
inline constexpr std::size_t kPoseMatches = 5;       ///< that a pose needs
inline constexpr double kHomographyThreshold = 3.0;  ///< of RANSAC, px
inline constexpr double kHomographyConfidence = 0.99999;
inline constexpr int kHomographyIterations =
    2000;  ///< of RANSAC at most; those of the pose are OpenCV's 1000
inline constexpr std::size_t kHomographyMatches = 4;  ///< that a homography needs

/// What a pose was computed from. The texts returned by toString() are part of poses.csv.
enum class PoseModel : std::uint8_t { kNone = 0, kEssential = 1, kHomography = 2 };

std::string toString(PoseModel model);

/// Throws std::invalid_argument listing the valid texts.
PoseModel poseModelFromString(const std::string& text);

struct PoseEstimate {
  PoseModel model = PoseModel::kNone;  ///< kNone: no pose was found, and the other members mean nothing
  cv::Matx33d rotation = cv::Matx33d::eye();
  cv::Vec3d translation;      ///< of length 1; zero where a homography says that the camera only turned
  std::size_t n_inliers = 0;  ///< matches within the threshold that lie in front of both cameras
};

/// Estimates the pose of the right camera from selected matches:
/// 1. the essential matrix by the five-point algorithm (Nister, PAMI 2004) in RANSAC, on coordinates that are
///    normalised by the camera matrices (cv::findEssentialMat);
/// 2. of its four decompositions the one that puts the most inliers in front of both cameras;
/// 3. rotation and direction of the translation that minimise the sum of squared Sampson distances of the
///    inliers (Levenberg-Marquardt), repeated while the inliers become more.
/// Where the selector estimated a homography, this is decomposed (Malis and Vargas 2007,
/// cv::decomposeHomographyMat), and the decomposition with the most inliers in front of both cameras goes
/// through step 3. It replaces the pose of the essential matrix unless that has more inliers, or as many with
/// a sum of squared distances that is more than 1 % smaller.
///
/// @param matches     selected ones, px; those with a coordinate that is not finite are left out
/// @param cameras     only its camera matrices are used
/// @param homography  the selector's model from left to right, px; none where it is of another kind
/// It does not throw because of data. Same matches in the same order, same bits. O(N) for 1000 hypotheses at
/// most.
PoseEstimate estimatePose(const Correspondences& matches, const RelativePose& cameras,
                          const std::optional<cv::Matx33d>& homography = {});

struct HomographyEstimate {
  cv::Matx33d homography;
  std::size_t n_inliers = 0;
};

/// Estimates the homography from selected matches by RANSAC and a refinement on its inliers
/// (cv::findHomography). None where it fails. Like estimatePose() otherwise.
std::optional<HomographyEstimate> estimateHomography(const Correspondences& matches);

}  // namespace corrsel::core
