#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "corrsel/evaluation/errors.h"
#include "corrsel/image_pair.h"
#include "corrsel/random.h"
#include "dataset_folder.h"
#include "geometry/fundamental.h"
#include "geometry/rigid_motion.h"

namespace corrsel::core::testing {

/// Bright dots in space, their images through a lens, and a comparison of what a reader makes of these.
class PosedScene : public DatasetFolder {
 protected:
  static constexpr int kWidth = 320, kHeight = 240;

  /// The camera that took all images, px.
  static cv::Matx33d camera() { return {260, 0, 163, 0, 255, 117, 0, 0, 1}; }

  /// Points in front of the cameras near the origin of the world.
  static std::vector<cv::Point3d> points() {
    std::vector<cv::Point3d> result;
    Random random(3);
    for (int i = 0; i < 12; ++i) {
      const double column = i % 4, row = i / 4;
      const double depth = 4 + 4 * random.uniform();
      result.emplace_back((column - 1.5) * 0.24 * depth, (row - 1) * 0.24 * depth, depth);
    }
    return result;
  }

  /// A pose, from the camera's frame to the world's: turned by angles about x, y, z, radians.
  static RigidMotion pose(const cv::Vec3d& angles, const cv::Vec3d& position) {
    cv::Matx33d rotation;
    cv::Rodrigues(angles, rotation);
    return {rotation, position};
  }

  /// Writes the image of a camera with this pose. @param path  relative to the test's folder
  void writeView(const std::string& file, const RigidMotion& pose,
                 const std::vector<double>& distortion = {}) const {
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(seenFrom(pose), cv::Vec3d(), cv::Vec3d(), camera(), distortion, pixels);
    writeDots(file, pixels);
  }

  /// The same through a fisheye lens. @param distortion  OpenCV's four coefficients
  void writeFisheyeView(const std::string& file, const RigidMotion& pose, const cv::Vec4d& distortion) const {
    std::vector<cv::Point2d> pixels;
    cv::fisheye::projectPoints(seenFrom(pose), pixels, cv::Vec3d(), cv::Vec3d(), camera(), distortion);
    writeDots(file, pixels);
  }

  /// Where the dot near a place is, px; NaN where there is none.
  static cv::Point2d dotNear(const cv::Mat& image, const cv::Point2d& place) {
    double sum = 0, x_sum = 0, y_sum = 0;
    for (int y = cvRound(place.y) - 6; y <= cvRound(place.y) + 6; ++y) {
      for (int x = cvRound(place.x) - 6; x <= cvRound(place.x) + 6; ++x) {
        if (x < 0 || y < 0 || x >= image.cols || y >= image.rows) return {NAN, NAN};
        const double weight = std::max(0, image.at<std::uint8_t>(y, x) - 24);
        sum += weight;
        x_sum += weight * x;
        y_sum += weight * y;
      }
    }
    return {x_sum / sum, y_sum / sum};
  }

  /// Checks that the dots lie where calibration and pose of the pair say, and that the truth fits to them.
  /// @param left_pose   of the left camera  @param turns  of the left image, counter-clockwise
  static void expectTruth(const ImagePair& pair, const RigidMotion& left_pose, int turns = 0) {
    ASSERT_TRUE(pair.truth.pose.has_value());
    const RelativePose& pose = *pair.truth.pose;
    EXPECT_NO_THROW(pose.check());
    RigidMotion to_left = left_pose.inverse();
    for (int i = 0; i < turns; ++i) to_left = RigidMotion{{0, 1, 0, -1, 0, 0, 0, 0, 1}, {}} * to_left;
    const RigidMotion to_right = RigidMotion{pose.rotation, pose.translation} * to_left;
    const auto projected = [](const cv::Matx33d& k, const RigidMotion& motion, const cv::Point3d& point) {
      const cv::Vec3d p = k * (motion.rotation * cv::Vec3d(point.x, point.y, point.z) + motion.translation);
      return cv::Point2d(p[0] / p[2], p[1] / p[2]);
    };
    int compared = 0;
    for (const cv::Point3d& point : points()) {
      const cv::Point2d left = projected(pose.left_camera, to_left, point);
      const cv::Point2d right = projected(pose.right_camera, to_right, point);
      const cv::Point2d left_dot = dotNear(pair.left, left), right_dot = dotNear(pair.right, right);
      if (std::isnan(left_dot.x) || std::isnan(right_dot.x)) continue;
      ++compared;
      EXPECT_LT(cv::norm(left_dot - left), 0.25) << left << " " << left_dot;
      EXPECT_LT(cv::norm(right_dot - right), 0.25) << right << " " << right_dot;
      if (pair.truth.kind == TruthKind::kFundamental) {
        EXPECT_LT(epipolarLineDistance(pair.truth.matrix, left_dot.x, left_dot.y, right_dot.x, right_dot.y),
                  0.4);
      }
    }
    EXPECT_GE(compared, 6);
  }

  /// Checks that images of fisheye lenses are raw, that their dots lie where cameras and pose say, and that
  /// the truth is that of the rays.
  static void expectFisheyeTruth(const ImagePair& pair, const RigidMotion& left_pose) {
    ASSERT_TRUE(pair.truth.pose && pair.left_camera && pair.right_camera);
    EXPECT_EQ(pair.left_camera->model, Camera::Model::kFisheye);
    EXPECT_EQ(pair.right_camera->model, Camera::Model::kFisheye);
    EXPECT_EQ(pair.truth.kind, TruthKind::kEssential);
    EXPECT_FALSE(pair.left_name.empty()) << "the images are those of the files";
    const RigidMotion to_left = left_pose.inverse();
    const RigidMotion to_right =
        RigidMotion{pair.truth.pose->rotation, pair.truth.pose->translation} * to_left;
    Correspondences dots;
    for (const cv::Point3d& point : points()) {
      const cv::Vec3d p(point.x, point.y, point.z);
      cv::Point2d left, right;
      ASSERT_TRUE(project(*pair.left_camera, to_left.rotation * p + to_left.translation, left));
      ASSERT_TRUE(project(*pair.right_camera, to_right.rotation * p + to_right.translation, right));
      const cv::Point2d left_dot = dotNear(pair.left, left), right_dot = dotNear(pair.right, right);
      if (std::isnan(left_dot.x) || std::isnan(right_dot.x)) continue;
      EXPECT_LT(cv::norm(left_dot - left), 0.25) << left << " " << left_dot;
      EXPECT_LT(cv::norm(right_dot - right), 0.25) << right << " " << right_dot;
      dots.add(left_dot, right_dot);
    }
    EXPECT_GE(dots.size(), 6u);
    pair.addCamerasTo(dots);
    for (const double error : groundTruthErrors(pair.truth, dots)) EXPECT_LT(error, 0.4);
  }

  static std::string text(const cv::Matx33d& matrix) {
    std::string result;
    for (const double value : matrix.val) result += " " + std::to_string(value);
    return result;
  }

  /// w x y z
  static cv::Vec4d quaternion(const cv::Matx33d& rotation) {
    cv::Vec3d turn;
    cv::Rodrigues(rotation, turn);
    const double angle = cv::norm(turn), s = angle > 0 ? std::sin(angle / 2) / angle : 0.5;
    return {std::cos(angle / 2), s * turn[0], s * turn[1], s * turn[2]};
  }

 private:
  /// points() in the frame of a camera.
  static std::vector<cv::Point3d> seenFrom(const RigidMotion& pose) {
    const RigidMotion to_camera = pose.inverse();
    std::vector<cv::Point3d> seen;
    for (const cv::Point3d& point : points()) {
      const cv::Vec3d at = to_camera.rotation * cv::Vec3d(point.x, point.y, point.z) + to_camera.translation;
      seen.emplace_back(at[0], at[1], at[2]);
    }
    return seen;
  }

  void writeDots(const std::string& file, const std::vector<cv::Point2d>& pixels) const {
    cv::Mat image(kHeight, kWidth, CV_8UC1, cv::Scalar(20));
    for (int y = 0; y < kHeight; ++y) {
      for (int x = 0; x < kWidth; ++x) {
        double value = 20;
        for (const cv::Point2d& pixel : pixels) {
          value += 200 * std::exp(-((x - pixel.x) * (x - pixel.x) + (y - pixel.y) * (y - pixel.y)) / 8);
        }
        image.at<std::uint8_t>(y, x) = cv::saturate_cast<std::uint8_t>(value);
      }
    }
    std::filesystem::create_directories((root_ / file).parent_path());
    ASSERT_TRUE(cv::imwrite((root_ / file).string(), image));
  }
};

}  // namespace corrsel::core::testing
