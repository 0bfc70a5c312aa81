#include <gtest/gtest.h>

#include <cmath>

#include "corrsel/evaluation/pinhole_view.h"

namespace corrsel::core {
namespace {

Camera fisheye() {
  Camera camera;
  camera.model = Camera::Model::kFisheye;
  camera.matrix = {200, 0, 320, 0, 210, 240, 0, 0, 1};
  camera.distortion = {0.01, -0.002};
  camera.size = {640, 480};
  return camera;
}

Camera panorama() {
  Camera camera;
  camera.model = Camera::Model::kEquirectangular;
  camera.size = {1000, 500};
  return camera;
}

TEST(PinholeView, HasTheMatrixOfTheCamera) {
  EXPECT_EQ(pinholeOf(fisheye()), fisheye().matrix);
  const cv::Matx33d k = pinholeOf(panorama());
  EXPECT_NEAR(k(0, 0), 1000 / (2 * CV_PI), 1e-12);
  EXPECT_EQ(k(0, 0), k(1, 1));
  EXPECT_EQ(cv::Point2d(k(0, 2), k(1, 2)), cv::Point2d(499.5, 249.5));
}

TEST(PinholeView, SeesWhatAPinholeWouldSee) {
  for (const Camera& camera : {fisheye(), panorama()}) {
    RelativePose pose;
    pose.left_camera = pose.right_camera = pinholeOf(camera);
    Correspondences matches;
    matches.left_camera = matches.right_camera = camera;
    const cv::Vec3d points[] = {{0, 0, 1}, {0.5, -0.3, 1}, {-2, 1, 1},
                                {4, 4, 1}, {1, 0, 0.1},    {0.3, 0.2, -1}};
    for (const cv::Vec3d& point : points) {
      cv::Point2d pixel;
      ASSERT_TRUE(project(camera, point, pixel)) << point;
      matches.add(pixel, pixel);
    }
    matches.left_frame = matches.right_frame = std::vector<AffineFrame>(matches.size());
    const Correspondences seen = throughPinholes(matches, pose);
    ASSERT_EQ(seen.size(), matches.size());
    EXPECT_TRUE(seen.left_frame.empty() && seen.right_frame.empty());
    EXPECT_FALSE(seen.left_camera || seen.right_camera);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      const cv::Vec3d expected = pose.left_camera * points[i];
      const bool visible = i < 4;  // the others are more than 80 degrees from the axis
      EXPECT_EQ(std::isnan(seen.left_x[i]), !visible) << i;
      EXPECT_EQ(std::isnan(seen.right_y[i]), !visible) << i;
      if (!visible) continue;
      EXPECT_NEAR(seen.left_x[i], expected[0] / expected[2], 0.01) << i;
      EXPECT_NEAR(seen.right_y[i], expected[1] / expected[2], 0.01) << i;
    }
  }
}

TEST(PinholeView, LeavesPinholesAlone) {
  Camera plain;
  plain.matrix = {300, 0, 160, 0, 300, 120, 0, 0, 1};
  Correspondences matches;
  matches.add({1, 2}, {3, 4});
  matches.left_camera = plain;  // that of the right image is not known
  const Correspondences seen = throughPinholes(matches, {});
  EXPECT_EQ(seen.left_x, matches.left_x);
  EXPECT_EQ(seen.right_y, matches.right_y);
  EXPECT_EQ(seen.left_camera, matches.left_camera);
  // One side alone is moved.
  matches.right_camera = fisheye();
  RelativePose pose;
  pose.right_camera = fisheye().matrix;
  EXPECT_EQ(throughPinholes(matches, pose).left_x, matches.left_x);
  EXPECT_NE(throughPinholes(matches, pose).right_x, matches.right_x);
}

}  // namespace
}  // namespace corrsel::core
