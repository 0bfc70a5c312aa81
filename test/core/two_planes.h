#pragma once

#include "test_support.h"

namespace corrsel::core::testing {

/// Two planes of 200 matches each in the two halves of the left image, 1 px noise, 400 uniform outliers.
/// `inlier` is the number of the plane, counted from 1.
inline Scene twoPlanes(std::uint64_t seed) {
  const cv::Matx33d planes[2] = {{1.02, 0.03, 15, -0.02, 0.98, 10, 2e-5, 1e-5, 1},
                                 {0.9, -0.15, 90, 0.12, 0.92, -40, -4e-5, 6e-5, 1}};
  Random random(seed);
  Scene scene;
  scene.matches.left_size = scene.matches.right_size = {640, 480};
  for (std::uint8_t plane = 0; plane < 2; ++plane) {
    for (int i = 0; i < 200; ++i) {
      const cv::Point2d left = uniformPoint(random, 320, 480) + cv::Point2d(320.0 * plane, 0);
      addMatch(scene, random, left, projected(planes[plane], left.x, left.y) + normalPoint(random), true);
      scene.inlier.back() = static_cast<std::uint8_t>(plane + 1);
    }
  }
  for (int i = 0; i < 400; ++i) {
    const cv::Point2d left = uniformPoint(random, 640, 480);
    addMatch(scene, random, left, uniformPoint(random, 640, 480), false);
  }
  return scene;
}

}  // namespace corrsel::core::testing
