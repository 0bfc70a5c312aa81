// The nodelet RigMonitor with generated matches: messages, diagnostics, and the files that it writes.

#include <camera_calibration_parsers/parse_yml.h>

#include <filesystem>
#include <opencv2/core.hpp>

#include "base/temporary_folder.h"
#include "core/rig_scene.h"
#include "corrsel/RigState.h"
#include "corrsel/ros/cameras.h"
#include "live_support.h"

namespace corrsel::testing {
namespace {

using core::rig_scene::bent;
using core::rig_scene::calibrated;
using core::rig_scene::kBaseline;
using core::rig_scene::kDegree;

/// The calibration of a camera whose rectified images are those of the scene.
sensor_msgs::CameraInfo infoOf(const cv::Matx33d& rotation, double baseline) {
  const core::Camera camera = core::rig_scene::camera();
  sensor_msgs::CameraInfo info;
  info.width = static_cast<std::uint32_t>(camera.size.width);
  info.height = static_cast<std::uint32_t>(camera.size.height);
  info.distortion_model = "plumb_bob";
  info.D = {-0.1, 0.02, 0, 0, 0};
  std::copy_n(camera.matrix.val, 9, info.K.begin());
  std::copy_n(rotation.val, 9, info.R.begin());
  for (std::size_t i = 0; i < 3; ++i) std::copy_n(&camera.matrix.val[3 * i], 3, &info.P[4 * i]);
  info.P[3] = -baseline * camera.matrix(0, 0);
  return info;
}

class RigMonitor : public ::testing::Test {
 protected:
  RigMonitor() : nh_("/case_" + std::to_string(++cases_)), monitor_(nh_.getNamespace() + "/rig_monitor") {
    ros::param::set(monitor_ + "/output_folder", folder());
    left_.P = infoOf(cv::Matx33d::eye(), 0).P;
  }

  void start() {
    matches_ = nh_.advertise<Correspondences>("matches", 1000);
    left_publisher_ = nh_.advertise<sensor_msgs::CameraInfo>("left/camera_info", 1, true);
    right_publisher_ = nh_.advertise<sensor_msgs::CameraInfo>("right/camera_info", 1, true);
    left_publisher_.publish(left_);
    right_publisher_.publish(right_);
    states_ = std::make_unique<Inbox<RigState>>(nh_, "rig_state");
    diagnostics_ = std::make_unique<Diagnostics>(nh_);
    ASSERT_TRUE(nodelets_.load(monitor_, "corrsel/RigMonitor"));
    ASSERT_TRUE(waitFor([this] {
      return states_->connected() && matches_.getNumSubscribers() > 0 &&
             left_publisher_.getNumSubscribers() > 0 && right_publisher_.getNumSubscribers() > 0;
    }));
  }

  /// Sends some seconds of a drive, each with its report. @return the last one
  RigStateConstPtr drive(const core::Pose& rig, int seconds) {
    RigStateConstPtr last;
    for (int i = 1; i <= 10 * seconds; ++i) {
      const core::Correspondences matches = scene_.next(rig);
      PairInfo info;
      info.header.stamp = ros::Time(scene_.time());
      info.header.frame_id = "left_camera_optical";
      info.right_stamp = info.header.stamp;
      info.right_frame_id = "right_camera_optical";
      info.rig = RigPose{calibrated().rotation, kBaseline * calibrated().translation};
      matches_.publish(toMsg(matches, info));
      // The first pair has a report, and every tenth after it.
      const bool reported = ++sent_ % 10 == 1;
      if (reported) last = states_->wait(info.header.stamp);
      if (reported && !last) return last;
    }
    return last;
  }

  std::string folder() const { return (folder_.path() / "rig").string(); }

  static inline int cases_ = 0;
  core::TemporaryFolder folder_{"rig_monitor_test"};
  ros::NodeHandle nh_;
  const std::string monitor_;
  const cv::Matx33d right_rotation_ = bent({0.5, 1.5, -1, 0, 0}).rotation;
  sensor_msgs::CameraInfo left_ = infoOf(cv::Matx33d::eye(), 0), right_ = infoOf(right_rotation_, kBaseline);
  core::rig_scene::Drive scene_{core::rig_scene::DriveSpec()};
  int sent_ = 0;
  ros::Publisher matches_, left_publisher_, right_publisher_;
  std::unique_ptr<Inbox<RigState>> states_;
  std::unique_ptr<Diagnostics> diagnostics_;
  Nodelets nodelets_;
};

sensor_msgs::CameraInfo readYaml(const std::string& path) {
  sensor_msgs::CameraInfo info;
  std::string name;
  EXPECT_TRUE(camera_calibration_parsers::readCalibrationYml(path, name, info)) << path;
  EXPECT_EQ(name + ".yaml", std::filesystem::path(path).filename().string());
  return info;
}

TEST_F(RigMonitor, ReportsARigThatIsFine) {
  start();
  const RigStateConstPtr state = drive(calibrated(), 7);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->state, RigState::STATE_OK) << state->message;
  EXPECT_EQ(state->header.frame_id, "left_camera_optical");
  EXPECT_EQ(state->right_frame_id, "right_camera_optical");
  EXPECT_GT(state->n_matches, 1000u);
  EXPECT_EQ(state->grid, 3u);
  EXPECT_EQ(state->region_median.size(), 9u);
  EXPECT_DOUBLE_EQ(state->calibrated_translation[0], -kBaseline);
  EXPECT_NE(state->message.find("length of the baseline cannot be observed"), std::string::npos);
  EXPECT_TRUE(waitFor([&] { return diagnostics_->of(monitor_, "rig").level == 0; })) << diagnostics_->text();
  EXPECT_FALSE(std::filesystem::exists(folder()));
}

TEST_F(RigMonitor, ReportsABentRigAndWritesItsCalibration) {
  start();
  const core::Pose truth = bent({0, 0, 0.5, 0, 0});
  const RigStateConstPtr state = drive(truth, 10);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->state, RigState::STATE_ERROR) << state->message;
  EXPECT_NEAR(state->deviation[2], 0.5 * kDegree, 0.02 * kDegree);
  EXPECT_LT(cv::norm(cv::Matx33d(state->corrected_rotation.data()) - truth.rotation), 0.05 * kDegree);
  EXPECT_EQ(state->observable[2], 1);
  EXPECT_TRUE(waitFor([&] { return diagnostics_->of(monitor_, "rig").level == 2; })) << diagnostics_->text();
  EXPECT_EQ(diagnostics_->of(monitor_, "rig").message.find("error: the right camera has turned by"), 0u);

  const sensor_msgs::CameraInfo left = readYaml(folder() + "/left.yaml");
  const sensor_msgs::CameraInfo right = readYaml(folder() + "/right.yaml");
  EXPECT_EQ(left.width, left_.width);
  EXPECT_EQ(right.distortion_model, "plumb_bob");
  EXPECT_NEAR(right.K[0], right_.K[0], 1e-6);
  EXPECT_NEAR(right.D[0], right_.D[0], 1e-9);
  const auto raw = rigOf(left, false, right, false), rectified = rigOf(left, true, right, true);
  ASSERT_TRUE(raw && rectified);
  // The images were rectified by R; the cameras themselves stand at R^T of that.
  EXPECT_LT(cv::norm(raw->rotation - right_rotation_.t() * truth.rotation), 0.05 * kDegree);
  EXPECT_NEAR(cv::norm(raw->translation), kBaseline, 1e-4);
  EXPECT_LT(cv::norm(rectified->rotation - cv::Matx33d::eye()), 1e-9);
  EXPECT_NEAR(rectified->translation[0], -kBaseline, 1e-4);
}

TEST_F(RigMonitor, RawImagesNeedNoWayBack) {
  // The matches are those of raw images: the poses of the calibration and of the scene are the same.
  right_ = infoOf(cv::Matx33d::eye(), kBaseline);
  start();
  const core::Pose truth = bent({0.5, 0, 0, 0, 0});
  const RigStateConstPtr state = drive(truth, 10);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->state, RigState::STATE_ERROR) << state->message;
  const auto raw = rigOf(readYaml(folder() + "/left.yaml"), false, readYaml(folder() + "/right.yaml"), false);
  ASSERT_TRUE(raw);
  EXPECT_LT(cv::norm(raw->rotation - truth.rotation), 0.05 * kDegree);
}

TEST_F(RigMonitor, MatchesWithoutARigAreNamed) {
  start();
  const core::Correspondences matches = scene_.next(calibrated());
  matches_.publish(toMsg(matches, {}));
  EXPECT_TRUE(waitFor([&] {
    const Diagnostics::Status status = diagnostics_->of(monitor_, "rig");
    return status.level == 1 && status.message.find("calibrated rig") != std::string::npos;
  })) << diagnostics_->text();
  // It goes on.
  const RigStateConstPtr state = drive(calibrated(), 1);
  EXPECT_TRUE(state);
}

TEST_F(RigMonitor, CalibrationOfOtherCamerasIsNotCorrected) {
  right_ = infoOf(right_rotation_, 2 * kBaseline);
  start();
  drive(bent({0.5, 0, 0, 0, 0}), 10);
  EXPECT_TRUE(waitFor([&] {
    return diagnostics_->of(monitor_, "rig").message.find("are not those of the matches") !=
           std::string::npos;
  })) << diagnostics_->text();
  EXPECT_FALSE(std::filesystem::exists(folder() + "/left.yaml"));
}

}  // namespace
}  // namespace corrsel::testing

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "rig_monitor_test");
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
