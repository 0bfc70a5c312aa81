#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/pose_result.h"

namespace corrsel::core {

/// What the verification of a pair found, with the numbers of COLMAP's column two_view_geometries.config.
enum class TwoViewConfig : std::uint8_t {
  kUndefined = 0,          ///< rejected: no relation between the images was found
  kDegenerate = 1,         ///< written by other programs only
  kCalibrated = 2,         ///< an essential matrix and a pose
  kUncalibrated = 3,       ///< a fundamental matrix
  kPlanar = 4,             ///< a homography of a plane
  kPanoramic = 5,          ///< a homography of a camera that only turned
  kPlanarOrPanoramic = 6,  ///< a homography, and which of both is not known
  kWatermark = 7,          ///< written by other programs only
  kMultiple = 8            ///< several motions: inliers without a matrix
};

/// "undefined", "degenerate", "calibrated", "uncalibrated", "planar", "panoramic", "planar_or_panoramic",
/// "watermark" or "multiple"; part of the file formats.
std::string toString(TwoViewConfig config);

/// Numbers of two keypoints that match: that of the first image, and that of the second one.
using KeypointPair = std::array<std::uint32_t, 2>;

/// The verified relation between two images, from the first to the second one. Lengths are px with the centre
/// of the first pixel at (0, 0); stores convert to the convention of their format. A matrix or pose that is
/// not known is absent, never invented.
struct TwoViewGeometry {
  TwoViewConfig config = TwoViewConfig::kUndefined;
  std::vector<KeypointPair> inliers;       ///< every keypoint at most once
  std::optional<cv::Matx33d> fundamental;  ///< x'^T F x = 0, px
  std::optional<cv::Matx33d> essential;    ///< d'^T E d = 0 for undistorted normalised coordinates
  std::optional<cv::Matx33d> homography;   ///< x' ~ H x, px
  std::optional<Pose> pose;                ///< X' = R X + t with |t| = 1 or 0
};

/// The relation from the second image to the first one. O(inliers).
TwoViewGeometry exchanged(const TwoViewGeometry& geometry);

}  // namespace corrsel::core
