#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

enum class SceneKind { kPlane, kSpace };

/// Describes matches to be generated between two images of 1024 x 768 px.
struct SceneSpec {
  SceneKind kind = SceneKind::kPlane;
  std::size_t n = 1000;
  double inlier_ratio = 0.5;
  std::uint64_t seed = 0;
  bool sorted = false;  ///< best ratio of descriptor distances first, as OpenCV's PROSAC expects
};

/// Generated matches with their ground truth.
struct MatchScene {
  Correspondences matches;               ///< with descriptor distances; planes also with frames; random order
  std::vector<std::uint8_t> inlier;      ///< one entry per match
  std::vector<cv::Point2f> left, right;  ///< the points of the matches, in the form that OpenCV takes
};

/// Generates the matches of a scene. Outliers are uniform in both images. Noise is Gaussian, per coordinate.
/// The ratios of descriptor distances are distributed as N(0.60, 0.12) for inliers and N(0.78, 0.10) for
/// outliers.
///
/// kPlane: a homography (rotation 8 degrees, scale 0.92, small perspective) maps the left points; the right
/// points have 1 px noise. The affine frames of inliers are related by the derivative of the homography with
/// 10 % noise, those of outliers by random similarities. kSpace: two cameras side by side (f = 900 px) see
/// points at a depth of 4 to 12; both images have 1 px noise.
///
/// O(n / inlier_ratio).
MatchScene makeScene(const SceneSpec& spec);

}  // namespace corrsel::core
