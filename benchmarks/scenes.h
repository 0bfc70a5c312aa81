#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::performance {

using Mask = std::vector<std::uint8_t>;  ///< one entry per match

/// kDescriptors is no scene: it stands for the two sets of descriptors that matchers are timed on.
enum class SceneKind { kPlane, kSpace, kDescriptors };

/// Generated matches between two images of 1024 x 768 px.
struct SceneSpec {
  SceneKind kind = SceneKind::kPlane;
  std::size_t n = 1000;
  double inlier_ratio = 0.5;
  std::uint64_t seed = 0;
  bool sorted = false;  ///< best ratio of descriptor distances first, as PROSAC in OpenCV wants it
};

struct Scene {
  core::Correspondences matches;  ///< with descriptor distances; planes also with frames; random order
  Mask inlier;
  std::vector<cv::Point2f> left, right;  ///< the same points once more, as OpenCV wants them
};

/// kPlane: a homography (rotation 8 degrees, scale 0.92, small perspective), right points with 1 px noise;
/// frames are the homography's derivative with 10 % noise, random similarities at outliers. kSpace: points at
/// depth 4 to 12 seen by two cameras side by side (f = 900 px), 1 px noise in both images. Outliers are
/// uniform in both images. Descriptor distance ratios: N(.60, .12) for inliers, N(.78, .10) for outliers.
/// Noise is per coordinate. O(n / inlier_ratio).
Scene makeScene(const SceneSpec& spec);

/// `count` scenes that differ in their seeds, 0, 1... Made on first use and kept.
std::shared_ptr<const std::vector<Scene>> scenes(SceneSpec spec, std::size_t count);

/// Share of the inliers that `model`, a homography from left to right in px, puts within `threshold` px.
double modelRecall(const Scene& scene, const cv::Matx33d& model, double threshold);

}  // namespace corrsel::performance
