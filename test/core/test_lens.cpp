#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "corrsel/camera_formats.h"
#include "datasets/lens.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

const cv::Matx33d kKinect = cameraMatrix(517.3, 516.5, 318.6, 255.3);
const std::vector<double> kKinectDistortion = {0.2624, -0.9531, -0.0054, 0.0026, 1.1633};

TEST(Lens, WithoutDistortionTouchesNothing) {
  const Lens lens("c", cameraFromOpenCv(kKinect, {0, 0, 0, 0}, {640, 480}));
  EXPECT_FALSE(lens.distorted());
  EXPECT_EQ(lens.camera().matrix, kKinect);
  const cv::Mat image(480, 640, CV_8UC3, cv::Scalar(1, 2, 3));
  EXPECT_EQ(lens.undistorted(image).data, image.data);
}

TEST(Lens, LeavesImagesOfFisheyesAndPanoramasAlone) {
  Camera fisheye;
  fisheye.model = Camera::Model::kFisheye;
  fisheye.matrix = kKinect;
  fisheye.distortion = {-0.02, 0.003};
  fisheye.size = {640, 480};
  Camera panorama;
  panorama.model = Camera::Model::kEquirectangular;
  panorama.size = {640, 480};
  const cv::Mat image(480, 640, CV_8UC1, cv::Scalar(9));
  for (const Camera& camera : {fisheye, panorama}) {
    const Lens lens("c", camera);
    EXPECT_FALSE(lens.distorted());
    EXPECT_EQ(lens.camera(), camera);
    EXPECT_EQ(lens.undistorted(image).data, image.data);
    EXPECT_THROW(lens.undistorted(cv::Mat(240, 320, CV_8UC1)), std::invalid_argument);
  }
  fisheye.matrix(0, 2) = 900;
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { Lens("c", fisheye); }), "its principal point"));
}

TEST(Lens, LeavesNoBorder) {
  const struct {
    cv::Matx33d camera;
    std::vector<double> distortion;
    cv::Size size;
  } lenses[] = {
      {kKinect, kKinectDistortion, {640, 480}},  // TUM RGB-D
      {cameraMatrix(520.9, 521, 325.1, 249.7), {0.2312, -0.7849, -0.0033, -0.0001, 0.9172}, {640, 480}},
      {cameraMatrix(458.654, 457.296, 367.215, 248.375),  // EuRoC, cam0
       {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05},
       {752, 480}},
      {cameraMatrix(3000, 3000, 2600, 1300), {-0.2, 0.05, 0, 0}, {6000, 4000}},
      {cameraMatrix(500, 500, 320, 240), {0.3, 0, 0, 0}, {640, 480}},
  };
  for (const auto& lens : lenses) {
    const Lens made("c", cameraFromOpenCv(lens.camera, lens.distortion, lens.size));
    EXPECT_TRUE(made.camera().isPlainPinhole());
    EXPECT_EQ(made.camera().size, lens.size);
    EXPECT_TRUE(made.distorted());
    const cv::Mat result = made.undistorted(cv::Mat(lens.size, CV_8UC1, cv::Scalar(255)));
    EXPECT_EQ(result.size(), lens.size);
    double least = 0;
    cv::minMaxLoc(result, &least);
    EXPECT_EQ(least, 255) << lens.camera;
    // Not more than necessary is cut off.
    EXPECT_LT(made.camera().matrix(0, 0), 1.5 * lens.camera(0, 0));
    EXPECT_GT(made.camera().matrix(0, 0), 0.6 * lens.camera(0, 0));
    EXPECT_TRUE(contains(made.text(), "images of c ("));
  }
}

TEST(Lens, SizesAreThoseOfImages) {
  EXPECT_EQ(imageSize(1, 1 << 20), cv::Size(1, 1 << 20));
  EXPECT_TRUE(
      mentions(errorOf<std::invalid_argument>([] { imageSize(640, 480.5); }), {"640x480.5", "1048576 px"}));
  for (const double side : {0.0, -1.0, 2097152.0, 1e300, double{NAN}}) {
    EXPECT_THROW(imageSize(640, side), std::invalid_argument) << side;
    EXPECT_THROW(imageSize(side, 480), std::invalid_argument) << side;
  }
}

TEST(Lens, NamesWhatIsWrong) {
  const auto errorFor = [](const cv::Matx33d& camera, const std::vector<double>& distortion) {
    Camera made;
    made.matrix = camera;
    std::copy(distortion.begin(), distortion.end(), made.distortion.begin());
    made.size = {640, 480};
    return errorOf<std::invalid_argument>([&] { Lens("cam0", made); });
  };
  EXPECT_TRUE(mentions(errorFor(cameraMatrix(NAN, 1, 1, 1), {}), {"cam0: ", "matrix", "not finite"}));
  EXPECT_TRUE(mentions(errorFor(cameraMatrix(500, -500, 320, 240), {}), {"cam0: ", "matrix", "-500"}));
  EXPECT_EQ(errorFor(cameraMatrix(500, 500, 900, 240), {}),
            "cam0 has its principal point at (900, 240), outside its images of 640x480 px");
  EXPECT_TRUE(contains(errorFor(cameraMatrix(500, 500, 320, 240), {-30, 0, 0, 0}),
                       "a distortion that cannot be removed"))
      << errorFor(cameraMatrix(500, 500, 320, 240), {-30, 0, 0, 0});
  const Lens lens("cam0", cameraFromOpenCv(kKinect, kKinectDistortion, {640, 480}));
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { lens.undistorted(cv::Mat(240, 320, CV_8UC1)); }),
                       {"320x240", "cam0", "640x480"}));
  const Lens unknown_size("K_a", cameraFromOpenCv(kKinect, {}, {}));
  EXPECT_NO_THROW(unknown_size.undistorted(cv::Mat(480, 640, CV_8UC1)));
  EXPECT_TRUE(contains(
      errorOf<std::invalid_argument>([&] { unknown_size.undistorted(cv::Mat(240, 320, CV_8UC1)); }),
      "the image has 320x240 px, and the principal point of K_a lies outside it, at (318.6, 255.3)"));
}

}  // namespace
}  // namespace corrsel::core
