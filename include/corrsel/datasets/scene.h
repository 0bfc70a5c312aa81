#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

enum class SceneKind { kPlane, kSpace };

/// Matches to be generated between two images of 1024 x 768 px.
struct SceneSpec {
  SceneKind kind = SceneKind::kPlane;
  std::size_t n = 1000;
  double inlier_ratio = 0.5;
  std::uint64_t seed = 0;
  bool sorted = false;  ///< best ratio of descriptor distances first, as PROSAC in OpenCV wants it
};

/// Generated matches, and which of them are right.
struct MatchScene {
  Correspondences matches;               ///< with descriptor distances; planes also with frames; random order
  std::vector<std::uint8_t> inlier;      ///< one entry per match
  std::vector<cv::Point2f> left, right;  ///< the same points once more, as OpenCV wants them
};

/// kPlane: a homography (rotation 8 degrees, scale 0.92, small perspective), right points with 1 px noise;
/// frames are the homography's derivative with 10 % noise, random similarities at outliers. kSpace: points at
/// depth 4 to 12 seen by two cameras side by side (f = 900 px), 1 px noise in both images. Outliers are
/// uniform in both images. Descriptor distance ratios: N(.60, .12) for inliers, N(.78, .10) for outliers.
/// Noise is per coordinate. O(n / inlier_ratio).
MatchScene makeScene(const SceneSpec& spec);

}  // namespace corrsel::core
