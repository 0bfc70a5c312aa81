#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "arbitrary.h"
#include "cameras.h"
#include "corrsel/camera.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Camera pinholeWith(const std::array<double, 8>& distortion) {
  Camera camera;
  camera.distortion = distortion;
  return camera;
}

void expectRay(const Camera& camera, const cv::Point2d& pixel, const cv::Vec3d& direction) {
  Ray ray;
  ASSERT_TRUE(unproject(camera, pixel, ray));
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(ray.direction[k], direction[k], 1e-11) << k;
}

void expectJacobian(const Camera& camera, const cv::Point2d& pixel, const std::array<double, 6>& jacobian) {
  Ray ray;
  ASSERT_TRUE(unproject(camera, pixel, ray));
  for (int k = 0; k < 6; ++k) EXPECT_NEAR(ray.jacobian.val[k], jacobian[k], 1e-11) << k;
}

// The expected numbers were computed by other software.
TEST(Camera, KnownRaysOfPinholes) {
  const Camera camera = radtanCamera();
  expectRay(camera, {100, 50}, {-0.575473130637, -0.193575576442, 0.794581129980});
  expectJacobian(
      camera, {100, 50},
      {0.000890496421, -0.000027282021, -0.000026741011, 0.000969651257, 0.000638424873, 0.000216467173});
  expectRay(camera, {1391, 511}, {0.660953858638, 0.249830946699, 0.707618890946});
  Ray ray;
  EXPECT_FALSE(unproject(camera, {-900, 250}, ray));
  EXPECT_TRUE(std::isnan(ray.direction[0]) && std::isnan(ray.jacobian(2, 1)));
}

TEST(Camera, KnownRaysOfFisheyes) {
  const Camera camera = fisheyeCamera();
  expectRay(camera, {100, 100}, {-0.810566848488, -0.570176309548, -0.133717463935});
  expectJacobian(
      camera, {100, 100},
      {0.000262508074, -0.000872204811, -0.000872204811, 0.000888906622, 0.002127846058, 0.001496788840});
  expectRay(camera, {639.5, 479.5}, {0, 0, 1});
  expectJacobian(camera, {639.5, 479.5}, {1.0 / 400, 0, 0, 1.0 / 400, 0, 0});
}

TEST(Camera, KnownRaysOfPanoramas) {
  const Camera camera = panoramaCamera();
  expectRay(camera, {100, 200}, {-0.175119720907, -0.816700572867, -0.549848395131});
  expectJacobian(camera, {100, 200},
                 {-0.001686913749, -0.000760371101, 0, 0.001770403039, 0.000537260575, -0.002387445727});
  expectRay(camera, {100 + 2048, 200}, {-0.175119720907, -0.816700572867, -0.549848395131});
  expectRay(camera, {1023.5, 511.5}, {0, 0, 1});
  Ray ray;
  EXPECT_TRUE(unproject(camera, {5, -0.5}, ray)) << "the pole";
  EXPECT_FALSE(unproject(camera, {5, -0.6}, ray)) << "beyond the pole";
  EXPECT_FALSE(unproject(camera, {5, 1024}, ray)) << "beyond the other pole";
}

// The kernels have their own sine and cosine.
TEST(Camera, RaysOfPanoramasAreExactToTheLastDigits) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const double x = random.uniform() * 2048 - 0.5;
    const double y = random.uniform() * 1024 - 0.5;
    const double longitude = 2 * CV_PI * ((x + 0.5) / 2048 - 0.5),
                 latitude = CV_PI * ((y + 0.5) / 1024 - 0.5);
    const cv::Vec3d expected(std::cos(latitude) * std::sin(longitude), std::sin(latitude),
                             std::cos(latitude) * std::cos(longitude));
    Ray ray;
    ASSERT_TRUE(unproject(panoramaCamera(), {x, y}, ray));
    for (int k = 0; k < 3; ++k) ASSERT_NEAR(ray.direction[k], expected[k], 4e-16) << x << " " << y;
  }
}

TEST(Camera, ProjectionsOfAPlainPinhole) {
  cv::Point2d pixel;
  ASSERT_TRUE(project(plainCamera(), {0.3, -0.2, 2}, pixel));
  EXPECT_NEAR(pixel.x, 700 * 0.15 + 2 * -0.1 + 320, 1e-12);
  EXPECT_NEAR(pixel.y, 710 * -0.1 + 240, 1e-12);
  EXPECT_FALSE(project(plainCamera(), {0.3, -0.2, -2}, pixel));
  EXPECT_FALSE(project(plainCamera(), {0.3, -0.2, 0}, pixel));
}

TEST(Camera, ProjectionUndoesUnprojection) {
  for (const auto& [name, camera] : allCameras()) {
    Random random(1);
    double largest = 0;
    for (int i = 0; i < (kSanitized ? 10000 : 100000); ++i) {
      const double x = random.uniform() * camera.size.width - 0.5;
      const double y = random.uniform() * camera.size.height - 0.5;
      Ray ray;
      cv::Point2d pixel;
      ASSERT_TRUE(unproject(camera, {x, y}, ray)) << name << " " << x << " " << y;
      ASSERT_TRUE(project(camera, 3 * ray.direction, pixel)) << name << " " << x << " " << y;
      largest = std::max(largest, std::hypot(pixel.x - x, pixel.y - y));
      ASSERT_NEAR(ray.direction.dot(ray.direction), 1, 1e-14) << name;
    }
    EXPECT_LT(largest, 1e-8) << name;
  }
}

TEST(Camera, JacobianIsTheDerivativeOfTheRay) {
  constexpr double kStep = 1e-3;  // px
  for (const auto& [name, camera] : allCameras()) {
    Random random(2);
    for (int i = 0; i < 1000; ++i) {
      cv::Point2d pixel;
      pixel.x = random.uniform() * (camera.size.width - 1);
      pixel.y = random.uniform() * (camera.size.height - 1);
      Ray ray;
      ASSERT_TRUE(unproject(camera, pixel, ray)) << name;
      for (int k = 0; k < 2; ++k) {
        const cv::Point2d step = k == 0 ? cv::Point2d(kStep, 0) : cv::Point2d(0, kStep);
        Ray before, after;
        ASSERT_TRUE(unproject(camera, pixel - step, before) && unproject(camera, pixel + step, after))
            << name;
        const cv::Vec3d numeric = (after.direction - before.direction) * (0.5 / kStep);
        for (int row = 0; row < 3; ++row) {
          ASSERT_NEAR(ray.jacobian(row, k), numeric[row], 2e-9) << name << " " << pixel << " " << row << k;
        }
      }
    }
  }
}

// With k1 = -0.3, r (1 - 0.3 r^2) is largest at r = 1.0541: 0.7027.
TEST(Camera, APointBeyondTheTurningPointHasNoRay) {
  const Camera camera = pinholeWith({-0.3});
  Ray ray;
  cv::Point2d pixel;
  EXPECT_TRUE(unproject(camera, {0.702, 0}, ray));
  EXPECT_TRUE(unproject(camera, {0, -0.702}, ray));
  EXPECT_FALSE(unproject(camera, {0.703, 0}, ray));
  EXPECT_TRUE(project(camera, {1.05, 0, 1}, pixel));
  EXPECT_FALSE(project(camera, {1.06, 0, 1}, pixel));
}

// r (1 - 0.5 r^2 + 0.08 r^4) turns at r = 0.931, where it is 0.583, and rises again from r = 1.698 on.
TEST(Camera, TheBranchBehindTheTurningPointIsNotTaken) {
  const Camera camera = pinholeWith({-0.5, 0.08});
  Ray ray;
  cv::Point2d pixel;
  EXPECT_TRUE(unproject(camera, {0.583, 0}, ray));
  for (const double x : {0.59, 1.0, 3.0, 9.0, 100.0}) EXPECT_FALSE(unproject(camera, {x, 0}, ray)) << x;
  EXPECT_FALSE(project(camera, {3, 0, 1}, pixel));
}

// r (1 + 0.3 r^2 - 0.1 r^4) is largest at r = 1.605: 1.780. So the images of some points lie farther out than
// the turning point.
TEST(Camera, AnImageFartherOutThanTheTurningPointHasARay) {
  const Camera camera = pinholeWith({0.3, -0.1});
  for (const double x : {1.5, 1.61, 1.7, 1.77}) {
    Ray ray;
    ASSERT_TRUE(unproject(camera, {0, x}, ray)) << x;
    const double r = ray.direction[1] / ray.direction[2], s = r * r;
    EXPECT_LT(r, 1.605);
    EXPECT_NEAR(r * (1 + 0.3 * s - 0.1 * s * s), x, 1e-11);
  }
  Ray ray;
  EXPECT_FALSE(unproject(camera, {0, 1.79}, ray));
}

// 1 / (1 - r^2) has a pole at r = 1.
TEST(Camera, ThePoleOfTheRationalModelIsNotPassed) {
  const Camera camera = pinholeWith({0, 0, 0, 0, 0, -1});
  Ray ray;
  cv::Point2d pixel;
  ASSERT_TRUE(unproject(camera, {0.9, 0}, ray));
  const double x = ray.direction[0] / ray.direction[2];
  EXPECT_NEAR(x / (1 - x * x), 0.9, 1e-12);
  EXPECT_FALSE(project(camera, {1.5, 0, 1}, pixel));
}

// th - 0.1 th^3 is largest at th = 1.826: 1.217.
TEST(Camera, AFisheyeImageEndsWhereItsRadiusTurns) {
  Camera camera = pinholeWith({-0.1});
  camera.model = Camera::Model::kFisheye;
  Ray ray;
  cv::Point2d pixel;
  ASSERT_TRUE(unproject(camera, {0, 1.217}, ray));
  EXPECT_LT(std::acos(ray.direction[2]), 1.8258);
  EXPECT_FALSE(unproject(camera, {0, 1.218}, ray));
  EXPECT_TRUE(project(camera, {0, std::sin(1.82), std::cos(1.82)}, pixel));
  EXPECT_FALSE(project(camera, {0, std::sin(1.83), std::cos(1.83)}, pixel));
}

TEST(Camera, AnEquidistantFisheyeSeesAllButTheDirectionBehindIt) {
  Camera camera;
  camera.model = Camera::Model::kFisheye;
  Ray ray;
  cv::Point2d pixel;
  expectRay(camera, {3, 0}, {std::sin(3.0), 0, std::cos(3.0)});
  EXPECT_FALSE(unproject(camera, {3.15, 0}, ray));
  EXPECT_TRUE(project(camera, {1e-3, 0, -1}, pixel));
  EXPECT_FALSE(project(camera, {0, 0, -1}, pixel));
}

TEST(Camera, NumbersThatAreNotFiniteHaveNoRay) {
  for (const auto& [name, camera] : allCameras()) {
    Ray ray;
    cv::Point2d pixel;
    for (const double wrong : {kNan, HUGE_VAL, -HUGE_VAL}) {
      EXPECT_FALSE(unproject(camera, {wrong, 100}, ray)) << name;
      EXPECT_FALSE(unproject(camera, {100, wrong}, ray)) << name;
      EXPECT_FALSE(project(camera, {0.1, wrong, 1}, pixel)) << name;
    }
    EXPECT_FALSE(project(camera, {0, 0, 0}, pixel)) << name;
  }
}

TEST(Camera, NoCameraMakesAWrongRay) {
  Random random(3);
  int valid = 0;
  for (int i = 0; i < 20000; ++i) {
    std::array<std::uint8_t, 64> bytes;
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random.next() >> 56);
    ByteSource source(bytes.data(), bytes.size());
    const Camera camera = arbitraryCamera(source);
    cv::Point2d pixel;
    pixel.x = arbitraryNumber(source, 300);
    pixel.y = arbitraryNumber(source, 200);
    cv::Vec3d point;
    for (double& value : point.val) value = arbitraryNumber(source, 2);
    EXPECT_EQ(cameraFault(camera, pixel, point), "") << i;
    valid += errorOf([&] { camera.check(); }).empty() ? 1 : 0;
  }
  EXPECT_GT(valid, 2000);
  EXPECT_LT(valid, 18000);
}

TEST(Camera, CheckNamesTheMemberItsValueAndWhatIsValid) {
  const auto errorAfter = [](auto&& change, Camera camera) {
    change(camera);
    return errorOf<std::invalid_argument>([&] { camera.check(); });
  };
  for (const auto& [name, camera] : allCameras()) EXPECT_NO_THROW(camera.check()) << name;
  EXPECT_TRUE(mentions(errorAfter([](Camera& c) { c.matrix(0, 0) = 0; }, plainCamera()),
                       {"matrix = [0 ", "positive fx and fy"}));
  EXPECT_TRUE(
      mentions(errorAfter([](Camera& c) { c.matrix(1, 0) = 2; }, fisheyeCamera()), {"matrix", "[fx s cx"}));
  EXPECT_TRUE(mentions(errorAfter([](Camera& c) { c.matrix(0, 2) = kNan; }, plainCamera()),
                       {"matrix", "not finite"}));
  EXPECT_TRUE(mentions(errorAfter([](Camera& c) { c.distortion[1] = kNan; }, radtanCamera()),
                       {"distortion[1] = nan", "not finite"}));
  EXPECT_TRUE(mentions(errorAfter([](Camera& c) { c.distortion[4] = 0.5; }, fisheyeCamera()),
                       {"distortion[4] = 0.5", "must be 0", "fisheye", "4"}));
  EXPECT_TRUE(mentions(errorAfter([](Camera& c) { c.distortion[0] = 0.5; }, panoramaCamera()),
                       {"distortion[0] = 0.5", "must be 0", "equirectangular"}));
  EXPECT_TRUE(
      mentions(errorAfter([](Camera& c) { c.size = {}; }, panoramaCamera()), {"size = 0x0", "positive"}));
  EXPECT_TRUE(
      mentions(errorAfter([](Camera& c) { c.size.width = -1; }, plainCamera()), {"size = -1x480", "0x0"}));
  EXPECT_EQ(errorAfter([](Camera& c) { c.size = {}; }, plainCamera()), "");
}

TEST(Camera, OnlyAPinholeWithoutDistortionIsPlain) {
  EXPECT_TRUE(plainCamera().isPlainPinhole());
  EXPECT_FALSE(radtanCamera().isPlainPinhole());
  EXPECT_FALSE(pinholeWith({0, 0, 0, 0, 0, 0, 0, 0.1}).isPlainPinhole());
  EXPECT_FALSE(panoramaCamera().isPlainPinhole());
  Camera equidistant;
  equidistant.model = Camera::Model::kFisheye;
  EXPECT_FALSE(equidistant.isPlainPinhole());
}

TEST(Camera, AScaledImageShowsTheSameRays) {
  for (const auto& [name, camera] : allCameras()) {
    const Camera half = camera.scaled(0.5);
    EXPECT_EQ(half.size, cv::Size(camera.size.width / 2, camera.size.height / 2));
    Ray large, small;
    ASSERT_TRUE(unproject(camera, {100, 200}, large) && unproject(half, {49.75, 99.75}, small)) << name;
    EXPECT_LT(cv::norm(large.direction - small.direction), 1e-12) << name;
    EXPECT_LT(cv::norm(2.0 * large.jacobian - small.jacobian), 1e-12) << name;
  }
  EXPECT_TRUE(
      mentions(errorOf<std::invalid_argument>([] { plainCamera().scaled(0); }), {"factor = 0", "positive"}));
}

TEST(Camera, EveryMemberIsCompared) {
  const Camera camera = radtanCamera();
  EXPECT_EQ(camera, radtanCamera());
  Camera other = camera;
  other.model = Camera::Model::kFisheye;
  EXPECT_NE(camera, other);
  other = camera;
  other.matrix(0, 1) = 1;
  EXPECT_NE(camera, other);
  other = camera;
  other.distortion[7] = 1;
  EXPECT_NE(camera, other);
  other = camera;
  other.size.width += 1;
  EXPECT_NE(camera, other);
}

TEST(Camera, ModelsHaveTexts) {
  for (const Camera::Model model :
       {Camera::Model::kPinhole, Camera::Model::kFisheye, Camera::Model::kEquirectangular}) {
    EXPECT_EQ(cameraModelFromString(toString(model)), model);
  }
  EXPECT_EQ(toString(Camera::Model::kPinhole), "pinhole");
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([] { cameraModelFromString("fisheyes"); }),
                       {"fisheyes", "did you mean 'fisheye'", "pinhole", "equirectangular"}));
}

TEST(Camera, InconsistentMatchesNameTheCamera) {
  Correspondences matches;
  matches.left_camera = plainCamera();
  matches.right_camera = fisheyeCamera();
  EXPECT_EQ(matches.inconsistency(), "");
  matches.right_camera->matrix(0, 0) = -1;
  EXPECT_TRUE(mentions(matches.inconsistency(), {"right_camera.matrix = [-1 "}));
  matches.left_camera->distortion[2] = kNan;
  EXPECT_TRUE(mentions(matches.inconsistency(), {"left_camera.distortion[2] = nan"}));
}

}  // namespace
}  // namespace corrsel::core
