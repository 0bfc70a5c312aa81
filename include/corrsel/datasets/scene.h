#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

enum class SceneKind { kPlane, kSpace };

/// Specification of generated matches between two images of 1024 x 768 px.
struct SceneSpec {
  SceneKind kind = SceneKind::kPlane;
  std::size_t n = 1000;
  double inlier_ratio = 0.5;
  std::uint64_t seed = 0;
  bool sorted = false;  ///< best ratio of descriptor distances first, as OpenCV's PROSAC requires
};

/// Generated matches with the mask of the correct ones.
struct MatchScene {
  Correspondences matches;               ///< with descriptor distances; planes also with frames; random order
  std::vector<std::uint8_t> inlier;      ///< one entry per match
  std::vector<cv::Point2f> left, right;  ///< the same points in OpenCV's types
};

/// Generates matches.
///
/// kPlane: the inliers follow a homography (rotation 8 degrees, scale 0.92, small perspective), and the right
/// points have 1 px noise. The frames of inliers are the derivative of the homography with 10 % noise, those
/// of outliers are random similarities.
///
/// kSpace: two cameras side by side (f = 900 px) see points at depth 4 to 12, with 1 px noise in both images.
///
/// Both: outliers are uniform in both images. The ratios of descriptor distances are N(.60, .12) for inliers
/// and N(.78, .10) for outliers. Noise is per coordinate.
///
/// Cost: O(n / inlier_ratio).
MatchScene makeScene(const SceneSpec& spec);

}  // namespace corrsel::core
