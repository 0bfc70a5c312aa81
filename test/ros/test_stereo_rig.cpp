#include <gtest/gtest.h>
#include <image_geometry/pinhole_camera_model.h>
#include <sensor_msgs/CameraInfo.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "geometry/fundamental.h"
#include "ros/bags/stereo_rig.h"

namespace corrsel {
namespace {

constexpr int kWidth = 640, kHeight = 480;
constexpr double kDotRadius = 1.8;  // px

/// A made-up rig: how its cameras are turned, what their lenses do, and where the right one stands.
struct RigParts {
  cv::Matx33d left_k{420, 0, 312, 0, 415, 236, 0, 0, 1}, right_k{431, 0, 330, 0, 428, 246, 0, 0, 1};
  cv::Matx33d left_m{400, 0, 320, 0, 400, 240, 0, 0, 1}, right_m{400, 0, 320, 0, 400, 240, 0, 0, 1};
  cv::Vec3d left_turn{0.02, -0.03, 0.01}, right_turn{-0.015, 0.025, -0.02};  // to the rectified frame
  cv::Vec3d baseline{-0.3, 0, 0};                                            // right X = left X + baseline
  std::vector<double> left_d{-0.28, 0.09, 4e-4, -3e-4, -0.01}, right_d{-0.26, 0.08, -2e-4, 5e-4, -0.008};
  std::string model = "plumb_bob";
};

cv::Matx33d rotation(const cv::Vec3d& turn) {
  cv::Matx33d matrix;
  cv::Rodrigues(turn, matrix);
  return matrix;
}

sensor_msgs::CameraInfo cameraInfo(const RigParts& parts, bool right) {
  sensor_msgs::CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = parts.model;
  info.D = right ? parts.right_d : parts.left_d;
  const cv::Matx33d& k = right ? parts.right_k : parts.left_k;
  const cv::Matx33d& m = right ? parts.right_m : parts.left_m;
  const cv::Matx33d r = rotation(right ? parts.right_turn : parts.left_turn);
  const cv::Vec3d p = right ? m * parts.baseline : cv::Vec3d();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      info.K[static_cast<std::size_t>(3 * i + j)] = k(i, j);
      info.R[static_cast<std::size_t>(3 * i + j)] = r(i, j);
      info.P[static_cast<std::size_t>(4 * i + j)] = m(i, j);
    }
    info.P[static_cast<std::size_t>(4 * i + 3)] = p[i];
  }
  return info;
}

RigCamera camera(const RigParts& parts, bool right, bool rectified = false) {
  return {cameraInfo(parts, right), rectified, right ? "/right/camera_info" : "/left/camera_info"};
}

StereoRig rig(const RigParts& parts, bool rectified = false) {
  return {camera(parts, false, rectified), camera(parts, true, rectified)};
}

/// Points of the rectified left frame that spread over the image at depths of 2 to 6 m.
std::vector<cv::Vec3d> points() {
  std::vector<cv::Vec3d> result;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 5; ++j) {
      const double depth = 2.0 + (7 * i + 3 * j) % 5;
      result.push_back({depth * (-0.5 + 0.2 * i), depth * (-0.36 + 0.18 * j), depth});
    }
  }
  return result;
}

cv::Point2d rectifiedPixel(const RigParts& parts, bool right, const cv::Vec3d& point) {
  const cv::Vec3d seen = right ? parts.right_m * (point + parts.baseline) : parts.left_m * point;
  return {seen[0] / seen[2], seen[1] / seen[2]};
}

/// Where the camera itself, with lens and without rectification, sees a point.
cv::Point2d rawPixel(const RigParts& parts, bool right, const cv::Vec3d& point) {
  const cv::Matx33d turn = rotation(right ? parts.right_turn : parts.left_turn);
  const cv::Vec3d seen = turn.t() * (right ? point + parts.baseline : point);
  const std::vector<cv::Point3d> object = {{seen[0], seen[1], seen[2]}};
  const std::vector<double>& d = right ? parts.right_d : parts.left_d;
  const cv::Matx33d& k = right ? parts.right_k : parts.left_k;
  std::vector<cv::Point2d> image;
  if (parts.model == "equidistant") {
    cv::fisheye::projectPoints(object, image, cv::Vec3d(), cv::Vec3d(), k, d);
  } else {
    cv::projectPoints(object, cv::Vec3d(), cv::Vec3d(), k, d, image);
  }
  return image.front();
}

/// Whether image_geometry has the model equidistant: from version 1.16 on.
bool knowsEquidistant() {
  sensor_msgs::CameraInfo info;
  info.width = kWidth;
  info.height = kHeight;
  info.distortion_model = "equidistant";
  info.D = {0.01, 0, 0, 0};
  info.K = {500, 0, 320, 0, 500, 240, 0, 0, 1};
  info.R = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.P = {500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0};
  image_geometry::PinholeCameraModel model;
  try {
    model.fromCameraInfo(info);
    cv::Mat rectified;
    model.rectifyImage(cv::Mat::zeros(kHeight, kWidth, CV_8UC1), rectified);
  } catch (const image_geometry::Exception&) {
    return false;
  }
  return true;
}

/// A raw image with a soft dot where the camera sees the point.
cv::Mat dotImage(const cv::Point2d& at, const cv::Size& size) {
  cv::Mat image(size, CV_8UC1, cv::Scalar(0));
  for (int y = std::max(0, cvFloor(at.y) - 9); y < std::min(size.height, cvFloor(at.y) + 10); ++y) {
    for (int x = std::max(0, cvFloor(at.x) - 9); x < std::min(size.width, cvFloor(at.x) + 10); ++x) {
      const double squared = (x - at.x) * (x - at.x) + (y - at.y) * (y - at.y);
      image.at<std::uint8_t>(y, x) =
          cv::saturate_cast<std::uint8_t>(250 * std::exp(-squared / (2 * kDotRadius * kDotRadius)));
    }
  }
  return image;
}

cv::Point2d centroid(const cv::Mat& image) {
  const cv::Moments moments = cv::moments(image);
  return {moments.m10 / moments.m00, moments.m01 / moments.m00};
}

bool wellInside(const cv::Point2d& at, const cv::Size& size) {
  return at.x >= 12 && at.y >= 12 && at.x < size.width - 12 && at.y < size.height - 12;
}

/// Shows points to both cameras and measures where the rectified images have them: on their epipolar lines,
/// and where P says. `offset` and `binning` turn full into recorded pixels.
void expectTrueMatchesOnTheirLines(const RigParts& parts, const StereoRig& rig, const cv::Size& size,
                                   const cv::Point2d& offset = {}, const cv::Point2d& binning = {1, 1}) {
  const auto recorded = [&](const cv::Point2d& full) {
    return cv::Point2d((full.x - offset.x) / binning.x, (full.y - offset.y) / binning.y);
  };
  const cv::Point2d left_corner = rig.leftArea().tl(), right_corner = rig.rightArea().tl();
  int seen = 0;
  double worst = 0, farthest = 0, unrectified = 0;
  for (const cv::Vec3d& point : points()) {
    const cv::Point2d left_raw = recorded(rawPixel(parts, false, point)),
                      right_raw = recorded(rawPixel(parts, true, point)),
                      left_ideal = recorded(rectifiedPixel(parts, false, point)) - left_corner,
                      right_ideal = recorded(rectifiedPixel(parts, true, point)) - right_corner;
    if (!wellInside(left_raw, size) || !wellInside(right_raw, size) ||
        !wellInside(left_ideal, rig.leftArea().size()) || !wellInside(right_ideal, rig.rightArea().size())) {
      continue;
    }
    ++seen;
    const cv::Mat left_image = rig.rectifyLeft(dotImage(left_raw, size)),
                  right_image = rig.rectifyRight(dotImage(right_raw, size));
    ASSERT_EQ(left_image.size(), rig.leftArea().size());
    ASSERT_EQ(right_image.size(), rig.rightArea().size());
    const cv::Point2d left = centroid(left_image), right = centroid(right_image);
    const auto distance = [&rig](const cv::Point2d& a, const cv::Point2d& b) {
      return core::epipolarLineDistance(rig.fundamental(), a.x, a.y, b.x, b.y);
    };
    worst = std::max(worst, distance(left, right));
    farthest = std::max({farthest, cv::norm(left - left_ideal), cv::norm(right - right_ideal)});
    unrectified = std::max(unrectified, distance(left_raw - left_corner, right_raw - right_corner));
    EXPECT_LT(distance(left_ideal, right_ideal), 1e-9);
  }
  EXPECT_GE(seen, 8);
  EXPECT_LT(worst, 0.1);
  EXPECT_LT(farthest, 0.1);
  EXPECT_GT(unrectified, 1.0) << "the rig is too well aligned to test anything";
}

std::string errorOf(const std::function<void()>& action) {
  try {
    action();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  ADD_FAILURE() << "no std::invalid_argument";
  return "";
}

void expectContains(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

/// The error for a left camera_info changed in one way, the right one being in order.
std::string leftError(const std::function<void(sensor_msgs::CameraInfo&)>& change, bool rectified = false) {
  RigCamera left = camera({}, false, rectified);
  change(left.info);
  return errorOf([&] { StereoRig(left, camera({}, true, rectified)); });
}

TEST(StereoRig, RawImagesHorizontalBaseline) {
  expectTrueMatchesOnTheirLines({}, rig({}), {kWidth, kHeight});
  EXPECT_NEAR(rig({}).baseline(), 0.3, 1e-12);
  EXPECT_NEAR(cv::norm(rig({}).fundamental()), 1.0, 1e-12);
}

TEST(StereoRig, RawImagesVerticalBaseline) {
  RigParts parts;
  parts.baseline = {0, -0.25, 0};
  expectTrueMatchesOnTheirLines(parts, rig(parts), {kWidth, kHeight});
}

TEST(StereoRig, DifferentCameraMatricesAndObliqueBaseline) {
  RigParts parts;
  parts.left_m = {390, 0, 330, 0, 395, 232, 0, 0, 1};
  parts.right_m = {410, 0, 300, 0, 405, 250, 0, 0, 1};
  parts.baseline = {-0.2, 0.1, 0.05};
  expectTrueMatchesOnTheirLines(parts, rig(parts), {kWidth, kHeight});
}

TEST(StereoRig, OtherDistortionModels) {
  RigParts rational;
  rational.model = "rational_polynomial";
  rational.left_d = {-0.2, 0.05, 3e-4, -2e-4, -0.01, 0.05, 0.01, -0.002};
  rational.right_d = {-0.18, 0.04, -2e-4, 1e-4, -0.008, 0.06, 0.01, -0.001};
  expectTrueMatchesOnTheirLines(rational, rig(rational), {kWidth, kHeight});
  if (!knowsEquidistant()) GTEST_SKIP() << "image_geometry does not know equidistant";
  RigParts equidistant;
  equidistant.model = "equidistant";
  equidistant.left_d = {-0.02, 0.003, -0.001, 1e-4};
  equidistant.right_d = {-0.015, 0.002, -0.0008, 1e-4};
  expectTrueMatchesOnTheirLines(equidistant, rig(equidistant), {kWidth, kHeight});
}

TEST(StereoRig, ZeroDistortionIsTurnedAllTheSame) {
  for (const std::string model : {"plumb_bob", "rational_polynomial", "equidistant", ""}) {
    SCOPED_TRACE(model);
    if (model == "equidistant" && !knowsEquidistant()) continue;
    RigParts parts;
    parts.model = model;
    parts.left_d.assign(model == "equidistant" ? 4 : 5, 0.0);
    parts.right_d = parts.left_d;
    expectTrueMatchesOnTheirLines(parts, rig(parts), {kWidth, kHeight});
  }
  RigParts parts;  // no coefficients at all
  parts.model = "";
  parts.left_d.clear();
  parts.right_d.clear();
  const StereoRig without = rig(parts);
  parts.left_d = parts.right_d = {0, 0, 0, 0, 0};
  expectTrueMatchesOnTheirLines(parts, without, {kWidth, kHeight});
}

TEST(StereoRig, RectifiedImagesAreTakenAsTheyAre) {
  const RigParts parts;
  const StereoRig rectified = rig(parts, true);
  const cv::Mat image = dotImage({100, 100}, {kWidth, kHeight});
  EXPECT_EQ(rectified.rectifyLeft(image).data, image.data);
  EXPECT_EQ(rectified.rectifyRight(image).data, image.data);
  for (const cv::Vec3d& point : points()) {
    const cv::Point2d left = rectifiedPixel(parts, false, point), right = rectifiedPixel(parts, true, point);
    EXPECT_LT(core::epipolarLineDistance(rectified.fundamental(), left.x, left.y, right.x, right.y), 1e-9);
    EXPECT_NEAR(core::epipolarLineDistance(rectified.fundamental(), left.x, left.y, right.x, right.y + 3),
                3.0, 1e-9);
  }
}

TEST(StereoRig, PoseProjectsPointsWhereTheImagesShowThem) {
  RigParts parts;
  parts.baseline = {-0.3, 0, 0};
  const core::RelativePose pose = rig(parts, true).pose();
  EXPECT_NO_THROW(pose.check());
  EXPECT_EQ(pose.rotation, cv::Matx33d::eye());
  EXPECT_LT(cv::norm(pose.translation - parts.baseline), 1e-9);
  for (const cv::Vec3d& point : points()) {
    const cv::Point2d left = rectifiedPixel(parts, false, point), right = rectifiedPixel(parts, true, point);
    const cv::Vec3d a = pose.left_camera * point;
    const cv::Vec3d b = pose.right_camera * (pose.rotation * point + pose.translation);
    EXPECT_LT(cv::norm(cv::Point2d(a[0] / a[2], a[1] / a[2]) - left), 1e-6);
    EXPECT_LT(cv::norm(cv::Point2d(b[0] / b[2], b[1] / b[2]) - right), 1e-6);
  }
  // Rectified images are cut to their areas, and so are their cameras.
  const StereoRig raw = rig(parts);
  const cv::Vec3d point(0.3, -0.2, 3);
  const cv::Point2d seen =
      centroid(raw.rectifyLeft(dotImage(rawPixel(parts, false, point), {kWidth, kHeight})));
  const cv::Vec3d a = raw.pose().left_camera * point;
  EXPECT_LT(cv::norm(cv::Point2d(a[0] / a[2], a[1] / a[2]) - seen), 0.1);
  EXPECT_EQ(raw.pose().fundamental(), raw.fundamental());
}

TEST(StereoRig, RectifiedImagesNeedNoLens) {
  const auto change = [](RigCamera camera) {
    camera.info.distortion_model = "omnidirectional";
    camera.info.D = {1};
    camera.info.K.fill(0);
    camera.info.R.fill(0);
    return camera;
  };
  const StereoRig rectified(change(camera({}, false, true)), change(camera({}, true, true)));
  EXPECT_EQ(rectified.fundamental(), rig({}, true).fundamental());
}

TEST(StereoRig, OneRawAndOneRectifiedCamera) {
  const RigParts parts;
  const StereoRig mixed(camera(parts, false, false), camera(parts, true, true));
  const cv::Vec3d point(0.3, -0.2, 3);
  const cv::Point2d left =
      centroid(mixed.rectifyLeft(dotImage(rawPixel(parts, false, point), {kWidth, kHeight})));
  const cv::Point2d right = rectifiedPixel(parts, true, point);
  EXPECT_LT(core::epipolarLineDistance(mixed.fundamental(), left.x, left.y, right.x, right.y), 0.1);
}

TEST(StereoRig, RegionOfInterestAndBinning) {
  const RigParts parts;
  RigCamera left = camera(parts, false), right = camera(parts, true);
  for (RigCamera* camera : {&left, &right}) {
    camera->info.roi.x_offset = 40;
    camera->info.roi.y_offset = 20;
    camera->info.roi.width = 560;
    camera->info.roi.height = 440;
  }
  expectTrueMatchesOnTheirLines(parts, StereoRig(left, right), {560, 440}, {40, 20});
  for (RigCamera* camera : {&left, &right}) {
    camera->info.roi = sensor_msgs::RegionOfInterest();
    camera->info.binning_x = camera->info.binning_y = 2;
  }
  expectTrueMatchesOnTheirLines(parts, StereoRig(left, right), {320, 240}, {}, {2, 2});
  left.info.roi.x_offset = 600;
  left.info.roi.width = left.info.roi.height = 100;
  expectContains(errorOf([&] { StereoRig(left, right); }), "region of interest");
}

TEST(StereoRig, NothingUnseenIsLeft) {
  const cv::Vec3b colour(10, 20, 30);
  RigParts small;  // P shows more than the cameras see
  small.left_m = small.right_m = {300, 0, 320, 0, 300, 240, 0, 0, 1};
  for (const RigParts& parts : {RigParts(), small}) {
    const StereoRig made = rig(parts);
    EXPECT_EQ(made.leftArea(), made.rightArea()) << "rows are no longer aligned";
    EXPECT_EQ(made.leftArea() & cv::Rect(0, 0, kWidth, kHeight), made.leftArea());
    EXPECT_GT(made.leftArea().area(), kWidth * kHeight / 3);
    const cv::Mat image(kHeight, kWidth, CV_8UC3, cv::Scalar(colour));
    for (const cv::Mat& rectified : {made.rectifyLeft(image), made.rectifyRight(image)}) {
      ASSERT_EQ(rectified.type(), CV_8UC3);
      cv::Mat differs;
      cv::inRange(rectified, cv::Scalar(colour), cv::Scalar(colour), differs);
      EXPECT_EQ(cv::countNonZero(differs == 0), 0);
    }
  }
  const StereoRig made = rig(small);
  EXPECT_LT(made.leftArea().width, kWidth);
  EXPECT_LT(made.leftArea().height, kHeight);
}

TEST(StereoRig, CamerasOfDifferentSizeKeepTheirOwnAreas) {
  RigParts parts;
  RigCamera left = camera(parts, false), right = camera(parts, true);
  right.info.height = 400;
  const StereoRig made(left, right);
  EXPECT_GT(made.leftArea().br().y, 400);
  EXPECT_LE(made.rightArea().br().y, 400);
}

TEST(StereoRig, RectificationThatShowsNothing) {
  expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.P[2] = 5000; }),
                 "next to nothing of the image");
}

TEST(StereoRig, ImageOfAnotherSize) {
  for (const bool rectified : {false, true}) {
    const StereoRig made = rig({}, rectified);
    const std::string error = errorOf([&] { made.rectifyRight(cv::Mat(240, 320, CV_8UC1, cv::Scalar(0))); });
    expectContains(error, "320x240 px");
    expectContains(error, "/right/camera_info is for 640x480 px");
  }
}

TEST(StereoRig, UncalibratedCamera) {
  const std::string error = leftError([](sensor_msgs::CameraInfo& info) {
    info = sensor_msgs::CameraInfo();
    info.width = kWidth;
    info.height = kHeight;
  });
  expectContains(error, "/left/camera_info is all zero: the camera is not calibrated");
  expectContains(error, "rosrun camera_calibration");
  expectContains(error, "GroundTruth");
}

TEST(StereoRig, CalibrationWithoutProjection) {
  expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.P.fill(0); }),
                 "/left/camera_info has K but no P");
  expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.K.fill(0); }),
                 "/left/camera_info has P but no K");
}

TEST(StereoRig, CamerasCalibratedOneByOne) {
  RigParts parts;
  parts.baseline = {0, 0, 0};
  for (const bool rectified : {false, true}) {
    const std::string error = errorOf([&] { rig(parts, rectified); });
    expectContains(error, "/left/camera_info and /right/camera_info");
    expectContains(error, "a baseline of zero");
    expectContains(error, "calibrate both cameras together");
  }
  const RigCamera same = camera({}, true);  // one topic for both
  expectContains(errorOf([&] { StereoRig(same, same); }), "a baseline of zero");
}

TEST(StereoRig, UnknownDistortionModel) {
  const std::string error =
      leftError([](sensor_msgs::CameraInfo& info) { info.distortion_model = "omnidirectional"; });
  expectContains(error, "/left/camera_info has the distortion model 'omnidirectional'");
  expectContains(error, "images = rectified");
}

TEST(StereoRig, ImpossibleNumbers) {
  expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.D.resize(3); }),
                 "3 distortion coefficients of the model 'plumb_bob'");
  expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.R.fill(0); }),
                 "R that is not a rotation");
  expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.P[0] = -400; }),
                 "P without positive focal lengths (-400, 400)");
  expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.K[4] = 0; }),
                 "K without positive focal lengths (420, 0)");
  expectContains(
      leftError([](sensor_msgs::CameraInfo& info) { info.K[2] = std::numeric_limits<double>::quiet_NaN(); }),
      "not finite");
  for (const bool rectified : {false, true}) {
    expectContains(leftError([](sensor_msgs::CameraInfo& info) { info.width = 0; }, rectified),
                   "image size 0x480");
  }
}

}  // namespace
}  // namespace corrsel
