#pragma once

#include <cstddef>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "measurement.h"

namespace corrsel::performance {

using core::CalibratedSceneSpec;

/// The threshold of all methods, px.
inline constexpr double kPoseThreshold = 1;

/// The selector `pose` on scenes of calibrated cameras.
Method pose(const CalibratedSceneSpec& scene, std::size_t scenes, const core::OptionMap& options = {});

/// cv::findEssentialMat and cv::recoverPose with their defaults. The points are undistorted beforehand, which
/// is not timed, and those that no pinhole sees are left out.
/// @param method  cv::RANSAC, CORRSEL_USAC(MAGSAC)
Method openCvPose(const std::string& name, const CalibratedSceneSpec& scene, std::size_t scenes, int method);

/// The matches of a scene for other libraries: best ratio of descriptor distances first, where there are any.
struct SortedMatches {
  std::vector<cv::Point2d> left, right;
  std::vector<std::size_t> rows;  ///< which match of the scene each one is

  /// The mask of the scene's matches for one of these.
  Mask maskOf(const std::vector<char>& selected, std::size_t n) const;
};

SortedMatches sortedMatches(const core::Correspondences& matches);

#ifdef CORRSEL_POSELIB
/// poselib::estimate_relative_pose with its defaults, which undistorts, refines the pose and, if there are
/// descriptor distances, samples by PROSAC.
Method poseLibPose(const CalibratedSceneSpec& scene, std::size_t scenes);
#endif

}  // namespace corrsel::performance
