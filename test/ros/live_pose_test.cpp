// Calibrations arrive beside the images, whenever they like, and poses go out with the selections.

#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <string>

#include "add_test_selector.h"
#include "corrsel/RelativePose.h"
#include "corrsel/ros/cameras.h"
#include "fixed_pose_selector.h"
#include "live_fixture.h"

namespace corrsel {
namespace {

using testing::imageMsg;
using testing::Inbox;
using testing::Live;
using testing::Log;
using testing::waitFor;
using namespace std::chrono_literals;

/// Of a rectified camera with the size of the fixture's images.
sensor_msgs::CameraInfo cameraInfoOf(double focal_length, double baseline = 0) {
  core::Camera camera;
  camera.matrix = {focal_length, 0, 160, 0, focal_length, 120, 0, 0, 1};
  camera.size = {320, 240};
  sensor_msgs::CameraInfo info = cameraInfo(camera);
  info.P[3] = -focal_length * baseline;
  return info;
}

class LivePose : public Live {
 protected:
  void SetUp() override {
    left_info_ = nh_.advertise<sensor_msgs::CameraInfo>("left/camera_info", 10, true);
    right_info_ = nh_.advertise<sensor_msgs::CameraInfo>("right/camera_info", 10, true);
  }

  /// The matches of one good pair.
  CorrespondencesConstPtr found() {
    const ros::Time stamp = nextStamp();
    send(stamp, good_, good_);
    return found_->wait(stamp);
  }

  /// Sends pairs until the left camera of their matches has a focal length; 0 = until it is unknown.
  bool becomes(double focal_length) {
    return waitFor([&] {
      const CorrespondencesConstPtr message = found();
      if (!message) return false;
      const Camera& camera = message->left_camera;
      return focal_length == 0 ? camera.model == Camera::MODEL_UNKNOWN : camera.matrix[0] == focal_length;
    });
  }

  ros::Publisher left_info_, right_info_;
};

TEST_F(LivePose, WithoutCameraInfoMatchesHaveNoCameras) {
  Log log;
  start();
  const CorrespondencesConstPtr message = found();
  ASSERT_TRUE(message);
  EXPECT_GT(message->left_x.size(), 50u);
  EXPECT_EQ(message->left_camera.model, Camera::MODEL_UNKNOWN);
  EXPECT_EQ(message->right_camera.model, Camera::MODEL_UNKNOWN);
  EXPECT_TRUE(std::isnan(message->rig_translation[0]));
  EXPECT_EQ(log.count("camera_info"), 0u) << log.text();
}

TEST_F(LivePose, CamerasGoWithTheMatchesAndFollowTheirChanges) {
  Log log;
  set(matcher() + "/images", std::string("rectified"));
  left_info_.publish(cameraInfoOf(300));
  right_info_.publish(cameraInfoOf(310, 0.12));
  start();
  ASSERT_TRUE(becomes(300));
  CorrespondencesConstPtr message;
  ASSERT_TRUE(waitFor([&] { return (message = found()) && message->right_camera.matrix[0] == 310; }));
  EXPECT_EQ(message->right_camera.model, Camera::MODEL_PINHOLE);
  EXPECT_EQ(message->right_camera.width, 320u);
  EXPECT_NEAR(message->rig_translation[0], -0.12, 1e-12);
  left_info_.publish(cameraInfoOf(350));  // a zoom lens
  EXPECT_TRUE(becomes(350));
  EXPECT_TRUE(waitFor([&] {
    return diagnostics_->of(matcher(), "processing").values["cameras"] ==
           "left pinhole, right pinhole, a rig";
  })) << diagnostics_->text();
  EXPECT_EQ(log.count("camera_info"), 0u) << log.text();
}

TEST_F(LivePose, WhatIsNoCalibrationIsSaidOnceAndTheMatchesGoOn) {
  Log log;
  left_info_.publish(cameraInfoOf(300));
  start();
  ASSERT_TRUE(becomes(300));
  sensor_msgs::CameraInfo bad = cameraInfoOf(300);
  bad.K[4] = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 20; ++i) {
    bad.header.stamp = nextStamp();
    left_info_.publish(bad);
    ASSERT_TRUE(found());
  }
  EXPECT_TRUE(becomes(0));
  EXPECT_EQ(log.count(ns_ + "/left/camera_info: K is [300"), 1u) << log.text();
  left_info_.publish(sensor_msgs::CameraInfo());  // a camera that was never calibrated
  EXPECT_TRUE(waitFor([&] {
    found();
    return log.count("not calibrated") > 0;
  }));
  const CorrespondencesConstPtr message = found();
  ASSERT_TRUE(message);
  EXPECT_GT(message->left_x.size(), 50u);
  left_info_.publish(cameraInfoOf(350));
  EXPECT_TRUE(becomes(350));
  EXPECT_EQ(log.count("not calibrated"), 1u) << log.text();
}

TEST_F(LivePose, ACalibrationOfAnotherSizeIsSaidOnceAndNotUsed) {
  Log log;
  sensor_msgs::CameraInfo large = cameraInfoOf(300);
  large.width = 640;
  large.height = 480;
  left_info_.publish(large);
  start();
  EXPECT_TRUE(waitFor([&] {
    const CorrespondencesConstPtr message = found();
    return message && log.count(ns_ + "/left/camera_info is for images of 640x480 px") > 0;
  })) << log.text();
  for (int i = 0; i < 5; ++i) {
    const CorrespondencesConstPtr message = found();
    ASSERT_TRUE(message);
    EXPECT_EQ(message->left_camera.model, Camera::MODEL_UNKNOWN);
  }
  EXPECT_EQ(log.count("is for images of"), 1u) << log.text();
  left_info_.publish(cameraInfoOf(350));
  EXPECT_TRUE(becomes(350));
}

TEST_F(LivePose, ASequenceHasTheOneCamera) {
  setDefaults();
  set(matcher() + "/mode", std::string("sequence"));
  ros::Publisher camera = nh_.advertise<sensor_msgs::Image>("image", 10);
  ros::Publisher info = nh_.advertise<sensor_msgs::CameraInfo>("camera_info", 10, true);
  info.publish(cameraInfoOf(300));
  openInboxes();
  loadMatcher();
  ASSERT_TRUE(waitFor([&] { return camera.getNumSubscribers() >= 1; }));
  EXPECT_TRUE(waitFor([&] {
    const ros::Time stamp = nextStamp();
    camera.publish(imageMsg(stamp, "camera", "mono8", good_));
    if (!waitFor([&] { return found_->has(stamp); }, 500ms)) return false;
    const CorrespondencesConstPtr message = found_->wait(stamp);
    return message->left_camera.matrix[0] == 300 && message->right_camera.matrix[0] == 300;
  }));
}

TEST_F(LivePose, PosesGoOutWithTheSelections) {
  testing::addTestSelector<testing::FixedPoseSelector>();
  left_info_.publish(cameraInfoOf(300));
  right_info_.publish(cameraInfoOf(310));
  setDefaults();
  set(selector() + "/selector", std::string(testing::FixedPoseSelector::kName));
  openCameras();
  diagnostics_ = std::make_unique<testing::Diagnostics>(nh_);
  loadMatcher();
  loadSelector();
  EXPECT_EQ(left_.getNumSubscribers(), 0u) << "nobody subscribes";
  Inbox<RelativePose> relative(nh_, "relative_pose");  // alone, it makes everything work
  Inbox<geometry_msgs::PoseWithCovarianceStamped> poses(nh_, "pose");
  ros::Time stamp;
  ASSERT_TRUE(waitFor([&] {
    stamp = nextStamp();
    send(stamp, good_, good_);
    return waitFor([&] { return relative.has(stamp) && poses.has(stamp); }, 500ms);
  }));
  EXPECT_EQ(relative.wait(stamp)->motion, RelativePose::MOTION_GENERAL);
  EXPECT_EQ(relative.wait(stamp)->header.frame_id, "left_camera_optical");
  EXPECT_EQ(relative.wait(stamp)->right_frame_id, "right_camera_optical");
  EXPECT_EQ(poses.wait(stamp)->header.frame_id, "left_camera_optical");
  EXPECT_EQ(poses.wait(stamp)->pose.pose.position.z, -1);
  EXPECT_TRUE(waitFor([&] { return diagnostics_->of(selector(), "processing").values["pose"] == "general"; }))
      << diagnostics_->text();

  // Where there is none, it is said in the one message, and the other one does not come.
  testing::configure(selector(), {{"options", "motion=0"}});
  stamp = nextStamp();
  send(stamp, good_, good_);
  const RelativePoseConstPtr none = relative.wait(stamp);
  ASSERT_TRUE(none);
  EXPECT_EQ(none->motion, RelativePose::MOTION_NONE);
  std::this_thread::sleep_for(100ms);
  EXPECT_FALSE(poses.has(stamp));

  // Selectors without a pose publish neither.
  testing::configure(selector(), {{"selector", "gms"}});
  EXPECT_TRUE(waitFor([&] {
    send(nextStamp(), good_, good_);
    std::this_thread::sleep_for(20ms);
    return diagnostics_->of(selector(), "processing").values["pose"] == "not estimated";
  })) << diagnostics_->text();
}

}  // namespace
}  // namespace corrsel
