// What is known of the motion between two images: from an IMU, from TF and from the last pose, and what the
// FeatureMatcher makes of it.

#include "ros/live/motion_source.h"

#include <gtest/gtest.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Imu.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/RelativePose.h"
#include "corrsel/ros/cameras.h"
#include "geometry/rotation_vector.h"
#include "live_fixture.h"
#include "ros/live/live_matcher.h"

namespace corrsel {
namespace {

using testing::Diagnostics;
using testing::imageMsg;
using testing::Inbox;
using testing::Live;
using testing::Log;
using testing::texture;
using testing::waitFor;
using Prior = FeatureMatcherParameters::Prior;
using Mode = FeatureMatcherParameters::Mode;

constexpr double kRadians = M_PI / 180;
constexpr char kFrame[] = "camera_optical";

double angleBetween(const cv::Matx33d& a, const cv::Matx33d& b) {
  return cv::norm(core::rotationVector(a.t() * b));
}

geometry_msgs::Quaternion quaternion(const cv::Vec3d& w) {
  const double angle = cv::norm(w);
  const cv::Vec3d axis = angle > 0 ? w * (std::sin(angle / 2) / angle) : cv::Vec3d();
  geometry_msgs::Quaternion q;
  q.x = axis[0];
  q.y = axis[1];
  q.z = axis[2];
  q.w = std::cos(angle / 2);
  return q;
}

sensor_msgs::Imu imu(double stamp, const cv::Vec3d& rate, const std::string& frame = "imu_link") {
  sensor_msgs::Imu message;
  message.header.stamp.fromSec(stamp);
  message.header.frame_id = frame;
  message.angular_velocity.x = rate[0];
  message.angular_velocity.y = rate[1];
  message.angular_velocity.z = rate[2];
  return message;
}

geometry_msgs::TransformStamped transform(double stamp, const std::string& parent, const std::string& child,
                                          const cv::Vec3d& w, const cv::Vec3d& t) {
  geometry_msgs::TransformStamped message;
  message.header.stamp.fromSec(stamp);
  message.header.frame_id = parent;
  message.child_frame_id = child;
  message.transform.rotation = quaternion(w);
  message.transform.translation.x = t[0];
  message.transform.translation.y = t[1];
  message.transform.translation.z = t[2];
  return message;
}

/// A source that knows what the test states.
class StatedMotion : public MotionSource {
 public:
  explicit StatedMotion(double timeout) : MotionSource(timeout) {}

  void subscribe() override {}
  void unsubscribe() override {}
  std::string name() const override { return "the test"; }
  std::vector<std::string> topics() const override { return {}; }
  Inputs inputs() const override { return {}; }

  std::optional<core::MotionGuess> guess;
  bool may_come = true;
  int known_from = 0;  ///< number of the call that knows it
  int calls = 0;

 private:
  std::optional<core::MotionGuess> find(const CameraMoment&, const CameraMoment&,
                                        std::string& why_missing) override {
    why_missing = "not stated";
    return calls++ < known_from ? std::nullopt : guess;
  }
  bool mayCome(const CameraMoment&, const CameraMoment&) const override { return may_come; }
};

const CameraMoment kNewer = {ros::Time(10.1), kFrame}, kEarlier = {ros::Time(10), kFrame};

TEST(MotionSource, WaitsForWhatMayComeOnly) {
  StatedMotion motion(10);
  motion.guess = core::MotionGuess();
  motion.known_from = 3;
  std::string why;
  EXPECT_TRUE(motion.between(kNewer, kEarlier, why));
  EXPECT_EQ(motion.calls, 4);
  motion.calls = 0;
  motion.may_come = false;
  EXPECT_FALSE(motion.between(kNewer, kEarlier, why));
  EXPECT_EQ(motion.calls, 1);
  EXPECT_EQ(why, "not stated");
  EXPECT_FALSE(motion.between({ros::Time(0), kFrame}, kEarlier, why));
  EXPECT_EQ(why, "a stamp is zero");
}

TEST(MotionSource, DoesNotWaitAgainAfterWaitingInVain) {
  StatedMotion motion(0.005);
  std::string why;
  EXPECT_FALSE(motion.between(kNewer, kEarlier, why));
  EXPECT_GT(motion.calls, 1);
  motion.calls = 0;
  EXPECT_FALSE(motion.between(kNewer, kEarlier, why));
  EXPECT_EQ(motion.calls, 1);
}

TEST(GuessStatistics, WarnsWhereMostAreContradicted) {
  GuessStatistics statistics;
  statistics.missing("no message on imu");
  for (int i = 0; i < 9; ++i) statistics.used(core::GuessVerdict::kContradicted);
  EXPECT_EQ(statistics.warning(), "");
  statistics.used(core::GuessVerdict::kContradicted);
  EXPECT_EQ(statistics.warning(),
            "contradicts the matches in 10 of the last 10 pairs: are stamps, frames and imu_rotation right?");
  for (int i = 0; i < 11; ++i) statistics.used(core::GuessVerdict::kConfirmed);
  statistics.used(core::GuessVerdict::kNone);
  EXPECT_EQ(statistics.warning(), "");
  EXPECT_EQ(statistics.text(),
            "confirmed 11, contradicted 10, not tested 1, missing 1 (last: no message on imu)");
}

TEST(MotionParameters, RotationsOfTheImuAreReadAndCheckedAsTheModeIs) {
  FeatureMatcherParameters parameters;
  EXPECT_FALSE(parameters.imuRotation());
  parameters.imu_rotation = "1.5707963267948966, -1.5707963267948966, 0";  // body to optical frame
  ASSERT_TRUE(parameters.imuRotation());
  const cv::Matx33d as_angles = *parameters.imuRotation();
  EXPECT_LT(cv::norm(cv::Matx33d(0, -1, 0, 0, 0, -1, 1, 0, 0) - as_angles), 1e-9);
  parameters.imu_rotation = "0.5, -0.5, 0.5, 0.5";
  ASSERT_TRUE(parameters.imuRotation());
  EXPECT_LT(cv::norm(*parameters.imuRotation() - as_angles), 1e-9);
  for (const char* wrong : {"1", "0.5, 0.5, 0.5, 0.9", "nan, 0, 0", "a, b, c"}) {
    parameters.imu_rotation = wrong;
    EXPECT_THROW(parameters.check(), std::invalid_argument) << wrong;
  }
  parameters.imu_rotation.clear();
  for (const Prior prior : {Prior::kImu, Prior::kLastPose}) {
    parameters.prior = prior;
    parameters.mode = Mode::kPair;
    EXPECT_THROW(parameters.check(), std::invalid_argument);
    parameters.mode = Mode::kSequence;
    EXPECT_NO_THROW(parameters.check());
  }
}

/// A source that is subscribed, with publishers before it.
class MotionSourceTest : public ::testing::Test {
 protected:
  MotionSourceTest() : nh_("/motion_" + std::to_string(++cases_)) {
    parameters_.mode = Mode::kSequence;
    parameters_.prior_timeout = 0;
    parameters_.prior_sigma = 0.1;
  }

  void open(Prior prior) {
    parameters_.prior = prior;
    motion_ = openMotionSource(nh_, parameters_);
    ASSERT_TRUE(motion_);
    motion_->subscribe();
  }

  /// Polls until the motion is known, or for a short time where `expected` is false.
  bool becomesKnown(const CameraMoment& left, const CameraMoment& right) {
    return waitFor([&] { return (guess_ = motion_->between(left, right, why_)).has_value(); },
                   std::chrono::seconds(10));
  }
  /// Polls until the motion is not known because of this.
  bool becomesMissing(const std::string& reason, const CameraMoment& left = kNewer,
                      const CameraMoment& right = kEarlier) {
    return waitFor(
        [&] { return !motion_->between(left, right, why_) && why_.find(reason) != std::string::npos; },
        std::chrono::seconds(10));
  }

  ros::Publisher connected(const ros::Publisher& publisher) {
    EXPECT_TRUE(waitFor([&] { return publisher.getNumSubscribers() > 0; }));
    return publisher;
  }

  static inline int cases_ = 0;
  ros::NodeHandle nh_;
  FeatureMatcherParameters parameters_;
  std::unique_ptr<MotionSource> motion_;
  std::optional<core::MotionGuess> guess_;
  std::string why_;
};

TEST_F(MotionSourceTest, NothingIsOpenedWithoutAPrior) { EXPECT_FALSE(openMotionSource(nh_, parameters_)); }

TEST_F(MotionSourceTest, ImuGivesTheRotationOfTheCamera) {
  parameters_.imu_rotation = "1.5707963267948966, -1.5707963267948966, 0";
  const ros::Publisher publisher = nh_.advertise<sensor_msgs::Imu>("imu", 2000);
  open(Prior::kImu);
  EXPECT_TRUE(becomesMissing("no message on imu"));
  connected(publisher);
  // The body turns to the left (about z, upwards): the camera turns about -y.
  for (int i = 0; i < 500; ++i) publisher.publish(imu(9.9 + 1e-3 * i, {0, 0, 1}));
  ASSERT_TRUE(becomesKnown(kNewer, kEarlier)) << why_;
  EXPECT_LT(angleBetween(guess_->rotation, core::rotationFromVector({0, -0.1, 0})), 1e-6);
  EXPECT_FALSE(guess_->translation);
  EXPECT_GT(guess_->rotation_sigma, 0.1 * kRadians);
  EXPECT_LT(guess_->rotation_sigma, 1 * kRadians);
  EXPECT_EQ(motion_->inputs().at(0).first, "imu");
  EXPECT_TRUE(becomesMissing("do not cover", {ros::Time(20), kFrame}, kEarlier));
  EXPECT_TRUE(becomesMissing("do not cover", kNewer, {ros::Time(5), kFrame}));
}

TEST_F(MotionSourceTest, ImuWithoutItsRotationTakesItFromTf) {
  const ros::Publisher publisher = nh_.advertise<sensor_msgs::Imu>("imu", 2000);
  const ros::Publisher tf = nh_.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
  open(Prior::kImu);
  connected(publisher);
  connected(tf);
  for (int i = 0; i < 50; ++i) publisher.publish(imu(9.9 + 1e-2 * i, {0, 0, 1}));
  EXPECT_TRUE(becomesMissing("set imu_rotation"));
  tf2_msgs::TFMessage message;
  message.transforms = {transform(0, "imu_link", kFrame, {M_PI / 2, 0, 0}, {1, 2, 3})};
  tf.publish(message);
  ASSERT_TRUE(becomesKnown(kNewer, kEarlier)) << why_;
  // The camera's frame is turned by 90 degrees about x: the z axis of the IMU is the y axis of the camera.
  EXPECT_LT(angleBetween(guess_->rotation, core::rotationFromVector({0, 0.1, 0})), 1e-6);
}

TEST_F(MotionSourceTest, ImuWithUnusableMessagesIsReportedAndRecovers) {
  parameters_.imu_rotation = "0, 0, 0";
  const ros::Publisher publisher = nh_.advertise<sensor_msgs::Imu>("imu", 2000);
  open(Prior::kImu);
  connected(publisher);
  sensor_msgs::Imu wrong = imu(10, {0, 0, 1});
  wrong.angular_velocity_covariance[0] = -1;
  publisher.publish(wrong);
  EXPECT_TRUE(becomesMissing("no angular velocity"));
  publisher.publish(imu(10, {0, 0, std::nan("")}));
  EXPECT_TRUE(becomesMissing("not finite"));
  publisher.publish(imu(0, {0, 0, 1}));
  EXPECT_TRUE(becomesMissing("are zero"));
  for (int i = 0; i < 50; ++i) publisher.publish(imu(9.9 + 1e-2 * i, {0, 0, 1}));
  EXPECT_TRUE(becomesKnown(kNewer, kEarlier)) << why_;
  publisher.publish(imu(3, {0, 0, 1}));  // a bag that starts again
  EXPECT_TRUE(becomesMissing("do not cover"));
  for (int i = 0; i < 50; ++i) publisher.publish(imu(3.1 + 1e-2 * i, {0, 0, 1}));
  EXPECT_TRUE(becomesKnown({ros::Time(3.3), kFrame}, {ros::Time(3.2), kFrame})) << why_;
}

TEST_F(MotionSourceTest, TfGivesRotationAndDirectionThroughTheFixedFrame) {
  parameters_.prior_min_translation = 0.1;
  const ros::Publisher tf = nh_.advertise<tf2_msgs::TFMessage>("/tf", 10);
  open(Prior::kTf);
  connected(tf);
  EXPECT_TRUE(becomesMissing("TF"));
  tf2_msgs::TFMessage message;
  message.transforms = {transform(10, "odom", kFrame, {0, 0, 0}, {5, 0, 0}),
                        transform(10.1, "odom", kFrame, {0, 0.2, 0}, {5, 0, 0.5}),
                        transform(10.2, "odom", kFrame, {0, 0.2, 0}, {5, 0, 0.55})};
  tf.publish(message);
  ASSERT_TRUE(becomesKnown(kNewer, kEarlier)) << why_;
  EXPECT_LT(angleBetween(guess_->rotation, core::rotationFromVector({0, 0.2, 0})), 1e-6);
  ASSERT_TRUE(guess_->translation);
  EXPECT_LT(cv::norm(*guess_->translation - cv::Vec3d(0, 0, 1)), 1e-6) << "it went forward";
  EXPECT_NEAR(guess_->rotation_sigma, 0.1 * kRadians, 1e-12);
  ASSERT_TRUE(becomesKnown({ros::Time(10.2), kFrame}, kNewer)) << why_;
  EXPECT_FALSE(guess_->translation) << "5 cm are less than prior_min_translation";
  EXPECT_TRUE(becomesMissing("future", {ros::Time(30), kFrame}, kEarlier));
  EXPECT_TRUE(becomesMissing("nobody", {ros::Time(10.1), "nobody"}, kEarlier));
}

TEST_F(MotionSourceTest, TfBetweenTwoCamerasNeedsNoFixedFrame) {
  parameters_.mode = Mode::kPair;
  parameters_.prior_fixed_frame = "no_such_frame";
  const ros::Publisher tf = nh_.advertise<tf2_msgs::TFMessage>("/tf_static", 10, true);
  open(Prior::kTf);
  connected(tf);
  tf2_msgs::TFMessage message;
  message.transforms = {transform(0, "left_eye", "right_eye", {0, 0.1, 0}, {0.5, 0, 0})};
  tf.publish(message);
  ASSERT_TRUE(becomesKnown({ros::Time(10), "left_eye"}, {ros::Time(10), "right_eye"})) << why_;
  EXPECT_LT(angleBetween(guess_->rotation, core::rotationFromVector({0, -0.1, 0})), 1e-6);
  ASSERT_TRUE(guess_->translation);
  EXPECT_LT((*guess_->translation)[0], -0.9);
}

/// A pose of the Selector between two images.
RelativePose pose(double stamp, double interval, const cv::Vec3d& w) {
  RelativePose message;
  message.header.stamp.fromSec(stamp);
  message.header.frame_id = message.right_frame_id = kFrame;
  message.right_stamp.fromSec(stamp - interval);
  message.motion = RelativePose::MOTION_ROTATION;
  message.rotation = quaternion(w);
  message.covariance.fill(std::nan(""));
  for (std::size_t k = 0; k < 3; ++k) message.covariance[6 * k] = 1e-8;
  message.noise = message.parallax = std::nan("");
  message.scale = std::nan("");
  return message;
}

TEST_F(MotionSourceTest, TheLastPoseGoesOn) {
  const ros::Publisher publisher = nh_.advertise<RelativePose>("relative_pose", 10);
  open(Prior::kLastPose);
  connected(publisher);
  EXPECT_TRUE(becomesMissing("no pose on relative_pose"));
  publisher.publish(pose(10, 0.1, {0, 0.05, 0}));
  ASSERT_TRUE(becomesKnown(kNewer, kEarlier)) << why_;
  EXPECT_LT(angleBetween(guess_->rotation, core::rotationFromVector({0, 0.05, 0})), 1e-6);
  const double even = guess_->rotation_sigma;
  EXPECT_LT(even, 0.2 * kRadians);
  ASSERT_TRUE(becomesKnown({ros::Time(10.2), kFrame}, kEarlier)) << why_;
  EXPECT_LT(angleBetween(guess_->rotation, core::rotationFromVector({0, 0.1, 0})), 1e-6) << "twice the time";
  EXPECT_TRUE(becomesMissing("too old", {ros::Time(12), kFrame}, {ros::Time(11.9), kFrame}));
  EXPECT_TRUE(becomesMissing("newer than the image", {ros::Time(9), kFrame}, {ros::Time(8.9), kFrame}));
  EXPECT_TRUE(becomesMissing("is of the frame", {ros::Time(10.1), "other"}, {ros::Time(10), "other"}));
  publisher.publish(pose(10.05, 0.1, {0, 0.15, 0}));
  ASSERT_TRUE(waitFor([&] {
    guess_ = motion_->between(kNewer, kEarlier, why_);
    return guess_ && angleBetween(guess_->rotation, core::rotationFromVector({0, 0.15, 0})) < 1e-6;
  }));
  EXPECT_GT(guess_->rotation_sigma, 0.05) << "the velocity changes";
}

TEST_F(MotionSourceTest, PosesThatAreNotToBeReliedOnAreNotUsed) {
  const ros::Publisher publisher = nh_.advertise<RelativePose>("relative_pose", 10);
  open(Prior::kLastPose);
  connected(publisher);
  RelativePose uncertain = pose(10, 0.1, {0, 1, 0}), failed = uncertain, none = uncertain;
  uncertain.uncertain = true;
  failed.status = Selection::STATUS_NO_MODEL;
  none.motion = RelativePose::MOTION_NONE;
  for (const RelativePose& message : {uncertain, failed, none}) publisher.publish(message);
  publisher.publish(pose(10.01, 0.1, {0, 0.02, 0}));
  ASSERT_TRUE(becomesKnown(kNewer, kEarlier)) << why_;
  EXPECT_LT(angleBetween(guess_->rotation, core::rotationFromVector({0, 0.02, 0})), 1e-6);
  EXPECT_LT(guess_->rotation_sigma, 0.2 * kRadians) << "the others would have been another velocity";
}

constexpr double kFocal = 300;

core::Camera turningCamera() {
  core::Camera camera;
  camera.matrix = {kFocal, 0, 159.5, 0, kFocal, 119.5, 0, 0, 1};
  camera.size = {320, 240};
  return camera;
}

/// A panorama on a sphere, seen by a camera that has turned about y by an angle.
cv::Mat seen(double angle) {
  static const cv::Mat panorama = [] {
    std::vector<cv::Mat> parts;
    for (std::uint64_t k = 0; k < 6; ++k) parts.push_back(texture(320, 480, 20 + k));
    cv::Mat image;
    cv::hconcat(parts, image);
    return image;
  }();
  cv::Mat map(240, 320, CV_32FC2);
  for (int y = 0; y < 240; ++y) {
    for (int x = 0; x < 320; ++x) {
      const double dx = (x - 159.5) / kFocal, dy = (y - 119.5) / kFocal;
      const double azimuth = std::atan(dx) + angle;
      map.at<cv::Vec2f>(y, x) = {static_cast<float>(960 + kFocal * azimuth),
                                 static_cast<float>(240 + kFocal * dy / std::hypot(dx, 1.0))};
    }
  }
  cv::Mat image;
  cv::remap(panorama, image, map, cv::noArray(), cv::INTER_LINEAR);
  return image;
}

class LiveMotion : public Live {
 protected:
  static constexpr double kStep = 0.1;  // s between the images

  void SetUp() override {
    setDefaults();
    set(matcher() + "/mode", std::string("sequence"));
    set(matcher() + "/prior", std::string("imu"));
    set(matcher() + "/imu_rotation", std::string("0, 0, 0"));
    set(matcher() + "/prior_timeout", 5.0);  // the machine may be busy
    set(matcher() + "/pending", 10);         // nothing is dropped
    camera_ = nh_.advertise<sensor_msgs::Image>("image", 10);
    info_ = nh_.advertise<sensor_msgs::CameraInfo>("camera_info", 10, true);
    imu_ = nh_.advertise<sensor_msgs::Imu>("imu", 2000);
    found_ = std::make_unique<Inbox<Correspondences>>(nh_, "correspondences");
    diagnostics_ = std::make_unique<Diagnostics>(nh_);
  }

  void load() {
    loadMatcher();
    ASSERT_TRUE(waitFor([&] { return camera_.getNumSubscribers() > 0 && info_.getNumSubscribers() > 0; }));
  }

  /// Sends the calibration of the camera and one rate, and waits until the rate has arrived. While none has
  /// arrived, a pair does not wait for the rates between its images.
  void loadWithImu() {
    info_.publish(cameraInfo(turningCamera()));
    load();
    ASSERT_TRUE(waitFor([&] { return imu_.getNumSubscribers() > 0; }));
    imu_.publish(imu(99.9, {0, 0, 0}));
    ASSERT_TRUE(waitFor([&] { return diagnostics_->of(matcher(), "input").values["imu received"] == "1"; }))
        << diagnostics_->text();
  }

  /// Sends the image k of a camera that turns at 2 rad/s and, after it, the rates since the one before.
  /// @param sign  of the rates; 0 = none are sent
  CorrespondencesConstPtr step(int k, double sign) {
    const ros::Time stamp(100 + kStep * k);
    camera_.publish(imageMsg(stamp, kFrame, "mono8", seen(2 * kStep * (k % 6))));
    for (int i = -18; sign != 0 && i <= 1; ++i) {
      const double t = 100 + kStep * k + 0.005 * i;
      imu_.publish(imu(t, {0, sign * (k > 0 && k % 6 == 0 ? -10.0 : 2.0), 0}));
    }
    return k == 0 ? nullptr : found_->wait(stamp);
  }

  std::string prior() { return diagnostics_->of(matcher(), "processing").values["prior"]; }

  ros::Publisher camera_, info_, imu_;
};

TEST_F(LiveMotion, TheGyroscopeGuidesTheMatching) {
  loadWithImu();
  int confirmed = 0;
  for (int k = 0; k < 6; ++k) {
    const CorrespondencesConstPtr message = step(k, 1);
    if (k == 0) continue;
    ASSERT_TRUE(message) << diagnostics_->text();
    const core::Correspondences matches = fromMsg(*message);
    ASSERT_TRUE(matches.left_camera);
    ASSERT_TRUE(matches.guess) << prior();
    EXPECT_LT(angleBetween(matches.guess->rotation, core::rotationFromVector({0, 2 * kStep, 0})), 0.01);
    confirmed += message->guess == Correspondences::GUESS_CONFIRMED ? 1 : 0;
  }
  EXPECT_EQ(confirmed, 5);
  EXPECT_TRUE(waitFor([&] { return prior().find("confirmed 5") == 0; })) << diagnostics_->text();
}

TEST_F(LiveMotion, AGyroscopeThatIsMountedTheOtherWayRoundIsReportedAndChangesNoMatch) {
  loadWithImu();
  const auto extractor = core::createExtractor("orb+orb", {{"orb", {{"max_features", "300"}}}});
  for (int k = 0; k < 6; ++k) {
    const CorrespondencesConstPtr message = step(k, -1);
    if (k == 0) continue;
    ASSERT_TRUE(message) << diagnostics_->text();
    EXPECT_EQ(message->guess, Correspondences::GUESS_CONTRADICTED) << k;
    const core::Features left = extractor->extract(seen(2 * kStep * k), 1);
    const core::Features right = extractor->extract(seen(2 * kStep * (k - 1)), 1);
    const core::Correspondences expected = core::matchFeatures(left, right);
    ASSERT_GT(expected.size(), 100u);
    EXPECT_EQ(message->right_index, expected.right_index);
    EXPECT_EQ(message->distance, expected.distance);
    EXPECT_EQ(message->second_distance, expected.second_distance);
  }
  Log log;
  for (int k = 6; k < 13; ++k) ASSERT_TRUE(step(k, -1));
  EXPECT_TRUE(waitFor([&] {
    return diagnostics_->of(matcher(), "processing")
               .values["last failure"]
               .find("the gyroscope contradicts") == 0;
  })) << diagnostics_->text();
  EXPECT_GE(log.count("the gyroscope contradicts the matches"), 1u) << log.text();
}

TEST_F(LiveMotion, WithoutAnImuOrACalibrationTheMatchesGoOn) {
  load();
  for (int k = 0; k < 3; ++k) {
    const CorrespondencesConstPtr message = step(k, 0);
    if (k == 0) continue;
    ASSERT_TRUE(message);
    EXPECT_GT(message->left_x.size(), 100u);
    EXPECT_EQ(message->guess, Correspondences::GUESS_NONE);
    EXPECT_FALSE(fromMsg(*message).guess);
  }
  EXPECT_TRUE(waitFor([&] {
    return prior().find("missing 2 (last: without camera_info") != std::string::npos;
  })) << diagnostics_->text();
  info_.publish(cameraInfo(turningCamera()));
  int k = 3;
  EXPECT_TRUE(waitFor([&] { return step(k++, 0) && prior().find("no message on imu") != std::string::npos; }))
      << diagnostics_->text();
}

TEST_F(LiveMotion, APriorThatTheModeDoesNotAllowIsAnError) {
  Log log;
  set(matcher() + "/mode", std::string("pair"));
  openCameras();
  loadMatcher();
  EXPECT_EQ(log.count("imu is for mode = sequence"), 1u) << log.text();
  std::string in_force;
  EXPECT_TRUE(ros::param::get(matcher() + "/prior", in_force));
  EXPECT_EQ(in_force, "none");
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "motion_source_test");
  ros::NodeHandle nh;  // keeps ROS running from the first to the last test
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
