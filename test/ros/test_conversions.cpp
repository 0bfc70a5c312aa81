#include <gtest/gtest.h>
#include <sensor_msgs/image_encodings.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/ros/conversions.h"
#include "features/parts/grey_image.h"

namespace corrsel {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Equal, with NaN equal to NaN.
template <class Vector>
void expectSame(const Vector& a, const Vector& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_TRUE(a[i] == b[i] || (a[i] != a[i] && b[i] != b[i])) << i;
}

void expectSame(const core::Correspondences& a, const core::Correspondences& b) {
  expectSame(a.left_x, b.left_x);
  expectSame(a.left_y, b.left_y);
  expectSame(a.right_x, b.right_x);
  expectSame(a.right_y, b.right_y);
  expectSame(a.distance, b.distance);
  expectSame(a.second_distance, b.second_distance);
  expectSame(a.probability, b.probability);
  EXPECT_EQ(a.left_frame, b.left_frame);
  EXPECT_EQ(a.right_frame, b.right_frame);
  EXPECT_EQ(a.left_index, b.left_index);
  EXPECT_EQ(a.right_index, b.right_index);
  EXPECT_EQ(a.left_size, b.left_size);
  EXPECT_EQ(a.right_size, b.right_size);
  EXPECT_EQ(a.left_camera, b.left_camera);
  EXPECT_EQ(a.right_camera, b.right_camera);
}

PairInfo exampleInfo() {
  PairInfo info;
  info.header.stamp = ros::Time(12, 34);
  info.header.frame_id = "left_camera_optical";
  info.right_stamp = ros::Time(12, 99);
  info.right_frame_id = "right_camera_optical";
  info.id = {"vgg", "graf", "1-3"};
  info.features = "sift+sift";
  info.rig = RigPose{{0, -1, 0, 1, 0, 0, 0, 0, 1}, {-0.12, 0.0, 0.01}};
  info.n_left_features = 100;
  info.n_right_features = 200;
  info.seconds.wait = 0.125;
  info.seconds.detect = 0.25;
  info.seconds.match = 0.5;  // describe stays NaN
  info.seconds.publish = 0.0625;
  return info;
}

core::Correspondences exampleMatches() {
  core::Correspondences matches;
  matches.add({1.5F, 2.5F}, {3.5F, 4.5F});
  matches.add({kNaN, 0.0F}, {std::numeric_limits<float>::infinity(), -1.0F});
  matches.distance = {0.5F, 0.25F};
  matches.second_distance = {1.0F, kNaN};
  matches.probability = {0.75F, kNaN};
  matches.left_frame = {{1, 2, 3, 4, 5, 6}, {7, 8, 9, 10, 11, 12}};
  matches.right_frame = {{-1, -2, -3, -4, -5, -6}, {0, 0, 0, 0, 0, 0}};
  matches.left_index = {7, 8};
  matches.right_index = {9, 9};
  matches.left_size = {640, 480};
  matches.right_size = {800, 600};
  matches.left_camera.emplace();
  matches.left_camera->matrix = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  matches.left_camera->size = matches.left_size;
  matches.right_camera = matches.left_camera;
  matches.right_camera->model = core::Camera::Model::kFisheye;
  matches.right_camera->distortion[0] = -0.02;
  return matches;
}

/// Expects std::invalid_argument whose text names `field`.
void expectRefused(const std::function<void()>& action, const std::string& field) {
  try {
    action();
    ADD_FAILURE() << "accepted, expected a complaint about " << field;
  } catch (const std::invalid_argument& error) {
    EXPECT_NE(std::string(error.what()).find(field), std::string::npos) << error.what();
  }
}

TEST(CorrespondencesMessage, RoundTripKeepsEverything) {
  const PairInfo info = exampleInfo();
  const core::Correspondences matches = exampleMatches();
  PairInfo back;
  expectSame(fromMsg(toMsg(matches, info), &back), matches);
  EXPECT_EQ(back.header.stamp, info.header.stamp);
  EXPECT_EQ(back.header.frame_id, info.header.frame_id);
  EXPECT_EQ(back.right_stamp, info.right_stamp);
  EXPECT_EQ(back.right_frame_id, info.right_frame_id);
  EXPECT_EQ(back.id, info.id);
  EXPECT_EQ(back.features, info.features);
  ASSERT_TRUE(back.rig);
  EXPECT_EQ(back.rig->rotation, info.rig->rotation);
  EXPECT_EQ(back.rig->translation, info.rig->translation);
  EXPECT_EQ(back.n_left_features, info.n_left_features);
  EXPECT_EQ(back.n_right_features, info.n_right_features);
  EXPECT_EQ(back.seconds.detect, info.seconds.detect);
  EXPECT_TRUE(std::isnan(back.seconds.describe));
  EXPECT_EQ(back.seconds.match, info.seconds.match);
  EXPECT_EQ(back.seconds.wait, info.seconds.wait);
  EXPECT_EQ(back.seconds.publish, info.seconds.publish);
}

core::ImageQuality exampleQuality() {
  core::ImageQuality quality;
  quality.black = 0.25;
  quality.saturated = 0.125;
  quality.blur = 1.5;
  quality.relative_blur = 2;
  quality.noise = 3.5;  // texture stays NaN
  return quality;
}

void expectSame(const core::ImageQuality& a, const core::ImageQuality& b) {
  EXPECT_EQ(a.black, b.black);
  EXPECT_EQ(a.saturated, b.saturated);
  EXPECT_EQ(a.blur, b.blur);
  EXPECT_EQ(a.relative_blur, b.relative_blur);
  EXPECT_EQ(a.noise, b.noise);
  EXPECT_EQ(std::isnan(a.texture), std::isnan(b.texture));
}

core::Correspondences guessedMatches() {
  core::Correspondences matches = exampleMatches();
  matches.guess.emplace();
  matches.guess->rotation = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  matches.guess->translation = cv::Vec3d(0, 0.6, -0.8);
  matches.guess->rotation_sigma = 0.25;
  return matches;
}

TEST(CorrespondencesMessage, RoundTripKeepsTheGuessAndTheQuality) {
  PairInfo info = exampleInfo(), back;
  info.guess = core::GuessVerdict::kContradicted;
  info.left_quality = exampleQuality();
  core::Correspondences matches = guessedMatches();
  for (const bool translates : {true, false}) {
    if (!translates) matches.guess->translation.reset();
    const core::Correspondences read = fromMsg(toMsg(matches, info), &back);
    ASSERT_TRUE(read.guess);
    EXPECT_EQ(read.guess->rotation, matches.guess->rotation);
    EXPECT_EQ(read.guess->translation, matches.guess->translation);
    EXPECT_EQ(read.guess->rotation_sigma, 0.25);
    EXPECT_EQ(back.guess, info.guess);
    expectSame(back.left_quality, info.left_quality);
    EXPECT_TRUE(std::isnan(back.right_quality.black));
  }
  EXPECT_FALSE(fromMsg(toMsg(exampleMatches(), {})).guess);
  EXPECT_FALSE(fromMsg(Correspondences()).guess) << "a message that was filled in by hand holds zeros";
}

TEST(CorrespondencesMessage, GuessesThatAreNoneAreNamed) {
  const auto with = [](const std::function<void(Correspondences&)>& damage) {
    Correspondences msg = toMsg(guessedMatches(), exampleInfo());
    damage(msg);
    return [msg] {
      PairInfo info;
      fromMsg(msg, &info);
    };
  };
  expectRefused(with([](Correspondences& m) { m.guess_rotation[0] = 1; }), "guess: rotation");
  expectRefused(with([](Correspondences& m) { m.guess_translation[0] = 2; }), "guess: translation");
  expectRefused(with([](Correspondences& m) { m.guess_sigma = -1; }), "guess: rotation_sigma");
  expectRefused(with([](Correspondences& m) { m.guess_sigma = std::nan(""); }), "guess: rotation_sigma");
  expectRefused(with([](Correspondences& m) { m.guess = 3; }), "guess");
}

TEST(CorrespondencesMessage, RoundTripOfCoordinatesOnly) {
  core::Correspondences matches;
  matches.add({1, 2}, {3, 4});
  const Correspondences msg = toMsg(matches, {});
  EXPECT_TRUE(msg.distance.empty());
  EXPECT_TRUE(msg.probability.empty());
  EXPECT_TRUE(msg.left_frame.empty());
  EXPECT_EQ(msg.left_width, 0u);
  EXPECT_EQ(msg.left_camera.model, Camera::MODEL_UNKNOWN);
  EXPECT_TRUE(std::isnan(msg.rig_rotation[0]));
  EXPECT_TRUE(std::isnan(msg.rig_translation[2]));
  EXPECT_TRUE(std::isnan(msg.seconds.detect));
  PairInfo back = exampleInfo();
  expectSame(fromMsg(msg, &back), matches);
  EXPECT_FALSE(back.rig);
}

TEST(CorrespondencesMessage, RoundTripOfNothing) {
  expectSame(fromMsg(toMsg(core::Correspondences(), {})), core::Correspondences());
  PairInfo back;
  expectSame(fromMsg(Correspondences(), &back), core::Correspondences());
  EXPECT_FALSE(back.rig) << "a message that was filled in by hand holds zeros";
}

TEST(CorrespondencesMessage, LengthsThatDisagreeAreNamed) {
  const auto with = [](const std::function<void(Correspondences&)>& damage) {
    Correspondences msg = toMsg(exampleMatches(), exampleInfo());
    damage(msg);
    return [msg] {
      PairInfo info;
      fromMsg(msg, &info);
    };
  };
  expectRefused(with([](Correspondences& m) { m.left_y.pop_back(); }), "left_y");
  expectRefused(with([](Correspondences& m) { m.right_x.push_back(0); }), "right_x");
  expectRefused(with([](Correspondences& m) { m.right_y.clear(); }), "right_y");
  expectRefused(with([](Correspondences& m) { m.distance.pop_back(); }), "distance");
  expectRefused(with([](Correspondences& m) { m.second_distance.pop_back(); }), "second_distance");
  expectRefused(with([](Correspondences& m) { m.probability.pop_back(); }), "probability");
  expectRefused(with([](Correspondences& m) { m.probability[0] = 1.5F; }), "probability");
  expectRefused(with([](Correspondences& m) { m.left_frame.pop_back(); }), "left_frame");
  expectRefused(with([](Correspondences& m) { m.right_frame.resize(6); }), "right_frame");
  expectRefused(with([](Correspondences& m) { m.left_index.push_back(1); }), "left_index");
  expectRefused(with([](Correspondences& m) { m.right_index.pop_back(); }), "right_index");
  expectRefused(with([](Correspondences& m) { m.left_width = 0xffffffffu; }), "left_width");
  expectRefused(with([](Correspondences& m) { m.right_height = 0xffffffffu; }), "right_height");
  expectRefused(with([](Correspondences& m) { m.left_camera.model = 9; }), "left_camera: model");
  expectRefused(with([](Correspondences& m) { m.right_camera.matrix[0] = kNaN; }), "right_camera: matrix");
  expectRefused(with([](Correspondences& m) { m.rig_rotation[0] = 2; }), "rig_rotation");
  expectRefused(with([](Correspondences& m) { m.rig_translation[0] = kNaN; }), "rig_translation");
  expectRefused(with([](Correspondences& m) { m.rig_translation.fill(0); }), "rig_translation");
}

core::Selection exampleSelection() {
  core::Selection selection;
  selection.mask = {1, 0, 1};
  selection.score = {0.5F, kNaN, 1.0F};
  selection.group = {0, -1, 2};
  selection.motion = {core::GroupMotion::kStatic, core::GroupMotion::kUnknown, core::GroupMotion::kMoving};
  selection.guess = core::GuessVerdict::kConfirmed;
  selection.model_kind = core::ModelKind::kFundamental;
  selection.model = cv::Matx33d(1, 2, 3, 4, 5, 6, 7, 8, 9);
  selection.status = core::Status::kTimeLimit;
  selection.scene = core::SceneKind::kSeveralMotions;
  selection.confidence = 12.5;
  selection.sigma = 0.75;
  selection.probability = {0.875F, 0.0F, 1.0F};
  selection.message = "stopped";
  selection.n_input = 3;
  selection.n_ignored = 1;
  selection.n_selected = 2;
  selection.iterations = 17;
  selection.seconds = 0.125;
  return selection;
}

TEST(SelectionMessage, RoundTripKeepsEverything) {
  const core::Selection selection = exampleSelection();
  PairInfo info;
  std::string selector;
  PairInfo sent = exampleInfo();
  sent.right_quality = exampleQuality();
  const core::Selection back = fromMsg(toMsg(selection, sent, "lpm:v2"), &info, &selector);
  EXPECT_EQ(back.motion, selection.motion);
  EXPECT_EQ(back.guess, selection.guess);
  expectSame(info.right_quality, sent.right_quality);
  EXPECT_TRUE(std::isnan(info.left_quality.blur));
  EXPECT_EQ(back.mask, selection.mask);
  expectSame(back.score, selection.score);
  EXPECT_EQ(back.group, selection.group);
  EXPECT_EQ(back.model_kind, selection.model_kind);
  EXPECT_EQ(back.model, selection.model);
  EXPECT_EQ(back.status, selection.status);
  EXPECT_EQ(back.scene, selection.scene);
  EXPECT_EQ(back.confidence, selection.confidence);
  EXPECT_EQ(back.sigma, selection.sigma);
  EXPECT_EQ(back.probability, selection.probability);
  EXPECT_EQ(back.message, selection.message);
  EXPECT_EQ(back.n_input, selection.n_input);
  EXPECT_EQ(back.n_ignored, selection.n_ignored);
  EXPECT_EQ(back.n_selected, selection.n_selected);
  EXPECT_EQ(back.iterations, selection.iterations);
  EXPECT_EQ(back.seconds, selection.seconds);
  EXPECT_EQ(selector, "lpm:v2");
  EXPECT_EQ(info.header.stamp, exampleInfo().header.stamp);
  EXPECT_EQ(info.right_frame_id, exampleInfo().right_frame_id);
  EXPECT_EQ(info.seconds.detect, exampleInfo().seconds.detect);
}

TEST(SelectionMessage, WithoutModelItIsNaN) {
  const Selection msg = toMsg(core::Selection(), {}, "gms");
  for (const double number : msg.model) EXPECT_TRUE(std::isnan(number));
  const core::Selection back = fromMsg(msg);
  EXPECT_EQ(back.model_kind, core::ModelKind::kNone);
  EXPECT_TRUE(back.mask.empty());
  EXPECT_TRUE(std::isnan(back.confidence)) << "nobody has computed it";
  EXPECT_TRUE(std::isnan(back.sigma));
  EXPECT_TRUE(back.probability.empty());
}

TEST(SelectionMessage, NonsenseIsNamed) {
  const auto with = [](const std::function<void(Selection&)>& damage) {
    Selection msg = toMsg(exampleSelection(), exampleInfo(), "gms");
    damage(msg);
    return [msg] { fromMsg(msg); };
  };
  expectRefused(with([](Selection& m) { m.status = 9; }), "status");
  expectRefused(with([](Selection& m) { m.confidence = -1; }), "confidence");
  expectRefused(with([](Selection& m) { m.sigma = -1; }), "sigma");
  expectRefused(with([](Selection& m) { m.sigma = std::numeric_limits<double>::infinity(); }), "sigma");
  expectRefused(with([](Selection& m) { m.probability.pop_back(); }), "probability");
  expectRefused(with([](Selection& m) { m.probability[1] = 1.5F; }), "probability");
  expectRefused(with([](Selection& m) { m.probability[1] = kNaN; }), "probability");
  expectRefused(with([](Selection& m) { m.scene = 6; }), "scene");
  expectRefused(with([](Selection& m) { m.model_kind = 5; }), "model_kind");
  expectRefused(with([](Selection& m) { m.mask[1] = 2; }), "mask");
  expectRefused(with([](Selection& m) { m.score.pop_back(); }), "score");
  expectRefused(with([](Selection& m) { m.group.pop_back(); }), "group");
  expectRefused(with([](Selection& m) { m.group[1] = -2; }), "group");
  expectRefused(with([](Selection& m) { m.motion.pop_back(); }), "motion");
  expectRefused(with([](Selection& m) { m.motion[1] = 3; }), "motion");
  expectRefused(with([](Selection& m) { m.guess = 3; }), "guess");
  expectRefused(with([](Selection& m) { m.n_input = 4; }), "n_input");
  expectRefused(with([](Selection& m) { m.n_selected = 3; }), "n_selected");
  expectRefused(with([](Selection& m) { m.model[4] = std::nan(""); }), "model");
}

TEST(SelectionMessage, EveryStatusAndKindHasItsConstant) {
  EXPECT_EQ(static_cast<int>(core::Status::kOk), Selection::STATUS_OK);
  EXPECT_EQ(static_cast<int>(core::Status::kTooFew), Selection::STATUS_TOO_FEW);
  EXPECT_EQ(static_cast<int>(core::Status::kDegenerate), Selection::STATUS_DEGENERATE);
  EXPECT_EQ(static_cast<int>(core::Status::kNoModel), Selection::STATUS_NO_MODEL);
  EXPECT_EQ(static_cast<int>(core::Status::kUnsupportedInput), Selection::STATUS_UNSUPPORTED_INPUT);
  EXPECT_EQ(static_cast<int>(core::Status::kTooLarge), Selection::STATUS_TOO_LARGE);
  EXPECT_EQ(static_cast<int>(core::Status::kTimeLimit), Selection::STATUS_TIME_LIMIT);
  EXPECT_EQ(static_cast<int>(core::Status::kFailed), Selection::STATUS_FAILED);
  EXPECT_EQ(static_cast<int>(core::Status::kUncertain), Selection::STATUS_UNCERTAIN);
  EXPECT_EQ(static_cast<int>(core::ModelKind::kNone), Selection::MODEL_NONE);
  EXPECT_EQ(static_cast<int>(core::ModelKind::kHomography), Selection::MODEL_HOMOGRAPHY);
  EXPECT_EQ(static_cast<int>(core::ModelKind::kFundamental), Selection::MODEL_FUNDAMENTAL);
  EXPECT_EQ(static_cast<int>(core::ModelKind::kEssential), Selection::MODEL_ESSENTIAL);
  EXPECT_EQ(static_cast<int>(core::ModelKind::kRotation), Selection::MODEL_ROTATION);
  EXPECT_EQ(static_cast<int>(core::TruthKind::kNone), GroundTruth::KIND_NONE);
  EXPECT_EQ(static_cast<int>(core::TruthKind::kHomography), GroundTruth::KIND_HOMOGRAPHY);
  EXPECT_EQ(static_cast<int>(core::TruthKind::kFundamental), GroundTruth::KIND_FUNDAMENTAL);
  EXPECT_EQ(static_cast<int>(core::TruthKind::kLabels), GroundTruth::KIND_LABELS);
  EXPECT_EQ(static_cast<int>(core::TruthKind::kDisparity), GroundTruth::KIND_DISPARITY);
}

TEST(GroundTruthMessage, RoundTripOfEveryKind) {
  core::GroundTruth truth;
  truth.matrix = cv::Matx33d(1, 2, 3, 4, 5, 6, 7, 8, 9);
  for (const core::TruthKind kind : {core::TruthKind::kHomography, core::TruthKind::kFundamental}) {
    truth.kind = kind;
    PairInfo info;
    const core::GroundTruth back = fromMsg(toMsg(truth, exampleInfo()), &info);
    EXPECT_EQ(back.kind, kind);
    EXPECT_EQ(back.matrix, truth.matrix);
    EXPECT_EQ(info.id, exampleInfo().id);
    EXPECT_EQ(info.header.stamp, exampleInfo().header.stamp);
  }

  truth.kind = core::TruthKind::kLabels;
  truth.labels = {0, 2, 1};
  const GroundTruth labels = toMsg(truth, {});
  EXPECT_TRUE(std::isnan(labels.matrix[0]));
  EXPECT_EQ(fromMsg(labels).labels, truth.labels);

  truth.kind = core::TruthKind::kDisparity;
  const cv::Mat wide = (cv::Mat_<float>(2, 4) << 1, kNaN, 3, 0, 4, 5, 6, 0);
  truth.disparity = wide.colRange(0, 3);  // rows that do not follow each other in memory
  const core::GroundTruth back = fromMsg(toMsg(truth, {}));
  ASSERT_EQ(back.disparity.size(), cv::Size(3, 2));
  EXPECT_TRUE(std::isnan(back.disparity.at<float>(0, 1)));
  EXPECT_EQ(back.disparity.at<float>(1, 0), 4.0F);
  EXPECT_EQ(back.disparity.at<float>(1, 2), 6.0F);

  EXPECT_EQ(fromMsg(toMsg(core::GroundTruth(), {})).kind, core::TruthKind::kNone);
}

TEST(GroundTruthMessage, PoseIsKeptWithAnyKind) {
  core::GroundTruth truth;
  truth.pose.emplace();
  truth.pose->left_camera = {700, 0, 320, 0, 710, 240, 0, 0, 1};
  truth.pose->right_camera = {800, 1, 300, 0, 810, 200, 0, 0, 1};
  truth.pose->rotation = {0, -1, 0, 1, 0, 0, 0, 0, 1};
  truth.pose->translation = {0.5, 0, -0.25};
  const core::GroundTruth back = fromMsg(toMsg(truth, {}));
  ASSERT_TRUE(back.pose.has_value());
  EXPECT_EQ(back.pose->left_camera, truth.pose->left_camera);
  EXPECT_EQ(back.pose->right_camera, truth.pose->right_camera);
  EXPECT_EQ(back.pose->rotation, truth.pose->rotation);
  EXPECT_EQ(back.pose->translation, truth.pose->translation);

  EXPECT_FALSE(fromMsg(toMsg(core::GroundTruth(), {})).pose.has_value());
  EXPECT_FALSE(fromMsg(GroundTruth()).pose.has_value()) << "a message that was filled in by hand holds zeros";
}

TEST(GroundTruthMessage, PartOfAPoseIsNamed) {
  core::GroundTruth truth;
  truth.pose.emplace();
  GroundTruth msg = toMsg(truth, {});
  msg.right_camera.fill(std::numeric_limits<double>::quiet_NaN());
  expectRefused([&] { fromMsg(msg); }, "right_camera");
  msg = toMsg(truth, {});
  msg.rotation[0] = -1;
  expectRefused([&] { fromMsg(msg); }, "rotation");
}

TEST(GroundTruthMessage, NonsenseIsNamed) {
  GroundTruth msg = toMsg(core::GroundTruth(), {});
  msg.kind = 7;
  expectRefused([&] { fromMsg(msg); }, "kind");
  msg.kind = GroundTruth::KIND_HOMOGRAPHY;  // the matrix is NaN
  expectRefused([&] { fromMsg(msg); }, "matrix");
  msg.kind = GroundTruth::KIND_DISPARITY;
  msg.disparity_width = 3;
  msg.disparity_height = 2;
  msg.disparity.assign(5, 0.0F);
  expectRefused([&] { fromMsg(msg); }, "disparity");
}

TEST(ScoreMessage, HoldsTheEvaluation) {
  core::Evaluation evaluation;
  evaluation.n_putative = 10;
  evaluation.n_ground_truth = 5;
  evaluation.n_selected = 4;
  evaluation.metrics.resize(2);
  evaluation.metrics[0].tau = 1.0;
  evaluation.metrics[0].n_correct = 3;
  evaluation.metrics[0].precision = 0.75;
  evaluation.metrics[1].tau = 2.0;
  ScoreLabels labels;
  labels.pair = exampleInfo();
  labels.selector = "gms";
  labels.status = core::Status::kTooFew;
  labels.select_seconds = 0.5;
  const Score msg = toMsg(evaluation, labels);
  EXPECT_EQ(msg.header.stamp, exampleInfo().header.stamp);
  EXPECT_EQ(msg.sequence, "graf");
  EXPECT_EQ(msg.features, "sift+sift");
  EXPECT_EQ(msg.preselection, "none");
  EXPECT_EQ(msg.selector, "gms");
  EXPECT_EQ(msg.status, Selection::STATUS_TOO_FEW);
  EXPECT_EQ(msg.n_putative, 10u);
  EXPECT_EQ(msg.n_ground_truth, 5u);
  EXPECT_EQ(msg.n_selected, 4u);
  ASSERT_EQ(msg.tolerance.size(), 2u);
  EXPECT_EQ(msg.tolerance[1], 2.0);
  EXPECT_EQ(msg.n_correct[0], 3u);
  EXPECT_EQ(msg.precision[0], 0.75);
  EXPECT_TRUE(std::isnan(msg.precision[1]));
  EXPECT_EQ(msg.f_paper.size(), 2u);
  EXPECT_EQ(msg.select_seconds, 0.5);
}

sensor_msgs::ImageConstPtr imageMsg(const std::string& encoding, const cv::Mat& image) {
  return cv_bridge::CvImage(std_msgs::Header(), encoding, image).toImageMsg();
}

TEST(ImageMessage, EightBitIsShared) {
  for (const char* encoding : {"mono8", "8UC1"}) {
    const auto msg = imageMsg(encoding, cv::Mat(3, 5, CV_8UC1, cv::Scalar(7)));
    EXPECT_EQ(fromMsg(msg)->image.data, msg->data.data()) << encoding;
    EXPECT_EQ(fromMsg(msg)->image.type(), CV_8UC1);
  }
  const auto colour = imageMsg("bgr8", cv::Mat(3, 5, CV_8UC3, cv::Scalar(1, 2, 3)));
  EXPECT_EQ(fromMsg(colour)->image.data, colour->data.data());
}

TEST(ImageMessage, OthersAreConverted) {
  EXPECT_EQ(fromMsg(imageMsg("rgb8", cv::Mat(3, 5, CV_8UC3, cv::Scalar(1, 2, 3))))->image.at<cv::Vec3b>(0, 0),
            cv::Vec3b(3, 2, 1));
  EXPECT_EQ(fromMsg(imageMsg("bgra8", cv::Mat(3, 5, CV_8UC4, cv::Scalar(1, 2, 3, 4))))->image.type(),
            CV_8UC3);
  for (const char* encoding : {"mono16", "16UC1"}) {
    const cv::Mat grey = fromMsg(imageMsg(encoding, cv::Mat(3, 5, CV_16UC1, cv::Scalar(65535))))->image;
    ASSERT_EQ(grey.type(), CV_8UC1) << encoding;
    EXPECT_EQ(grey.at<std::uint8_t>(0, 0), 255) << encoding;
  }
  EXPECT_EQ(fromMsg(imageMsg("bayer_rggb8", cv::Mat(4, 6, CV_8UC1, cv::Scalar(9))))->image.type(), CV_8UC3);
  EXPECT_EQ(fromMsg(imageMsg("yuv422", cv::Mat(4, 6, CV_8UC2, cv::Scalar(128, 128))))->image.type(), CV_8UC3);
}

TEST(ImageMessage, UnsupportedEncodingsAreNamed) {
  expectRefused([] { fromMsg(imageMsg("32FC1", cv::Mat(3, 5, CV_32FC1, cv::Scalar(1)))); }, "32FC1");
  const auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->encoding = "no such thing";
  expectRefused([&] { fromMsg(sensor_msgs::ImageConstPtr(msg)); }, "no such thing");
}

TEST(ImageMessage, DataThatDoesNotFitIsRefused) {
  const auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->encoding = "mono8";
  msg->width = 100;
  msg->height = 100;
  msg->step = 100;
  msg->data.resize(50);
  expectRefused([&] { fromMsg(sensor_msgs::ImageConstPtr(msg)); }, "mono8");
  msg->step = 10;
  msg->data.resize(1000);
  expectRefused([&] { fromMsg(sensor_msgs::ImageConstPtr(msg)); }, "mono8");
}

TEST(ImageMessage, BigEndianIsReadAsSuch) {
  for (const std::string encoding :
       {"mono16", "16UC1", "16UC3", "16UC4", "bgr16", "rgb16", "bgra16", "rgba16", "bayer_rggb16",
        "bayer_bggr16", "bayer_gbrg16", "bayer_grbg16"}) {
    const int channels = sensor_msgs::image_encodings::numChannels(encoding);
    cv::Mat image(6, 8, CV_16UC(channels));
    cv::randu(image, 0, 65536);
    const sensor_msgs::ImageConstPtr little = imageMsg(encoding, image);
    ASSERT_FALSE(little->is_bigendian);
    const auto big = boost::make_shared<sensor_msgs::Image>(*little);
    big->is_bigendian = 1;
    for (std::size_t i = 0; i < big->data.size(); i += 2) std::swap(big->data[i], big->data[i + 1]);
    const cv::Mat a = fromMsg(little)->image, b = fromMsg(sensor_msgs::ImageConstPtr(big))->image;
    ASSERT_EQ(a.type(), channels == 1 && encoding[0] != 'b' ? CV_8UC1 : CV_8UC3) << encoding;
    EXPECT_EQ(a.size(), image.size()) << encoding;
    EXPECT_EQ(cv::norm(a, b, cv::NORM_INF), 0.0) << encoding;
    EXPECT_GT(cv::norm(a, cv::NORM_INF), 200.0) << encoding;  // scaled, not cut
  }
}

TEST(ImageMessage, FourChannelsWithoutAMeaningAreBgra) {
  EXPECT_EQ(
      fromMsg(imageMsg("8UC4", cv::Mat(3, 5, CV_8UC4, cv::Scalar(1, 2, 3, 4))))->image.at<cv::Vec3b>(2, 4),
      cv::Vec3b(1, 2, 3));
  EXPECT_EQ(fromMsg(imageMsg("16UC4", cv::Mat(3, 5, CV_16UC4, cv::Scalar(257, 514, 771, 9))))
                ->image.at<cv::Vec3b>(2, 4),
            cv::Vec3b(1, 2, 3));
}

TEST(ImageMessage, RowsMayBePadded) {
  const auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->encoding = "mono16";
  msg->width = 2;
  msg->height = 3;
  msg->step = 8;
  msg->is_bigendian = 1;
  msg->data.assign(24, 0xff);
  for (std::size_t y = 0; y < 3; ++y) {
    for (std::size_t x = 0; x < 2; ++x) {
      msg->data[8 * y + 2 * x] = static_cast<std::uint8_t>(10 * y + x);
      msg->data[8 * y + 2 * x + 1] = 0;
    }
  }
  const cv::Mat image = fromMsg(sensor_msgs::ImageConstPtr(msg))->image;
  ASSERT_EQ(image.size(), cv::Size(2, 3));
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 2; ++x) EXPECT_NEAR(image.at<std::uint8_t>(y, x), 10 * y + x, 1);
  }
}

const std::vector<std::string> kSupported = {
    "mono8",        "mono16",       "bgr8",         "rgb8",         "bgra8",
    "rgba8",        "bgr16",        "rgb16",        "bgra16",       "rgba16",
    "8UC1",         "8UC3",         "8UC4",         "16UC1",        "16UC3",
    "16UC4",        "bayer_rggb8",  "bayer_bggr8",  "bayer_gbrg8",  "bayer_grbg8",
    "bayer_rggb16", "bayer_bggr16", "bayer_gbrg16", "bayer_grbg16", "yuv422"};

TEST(ImageMessage, FeaturesNeedFewerCopies) {
  core::GreyBuffer buffer;
  const std::set<std::string> shared = {"mono8", "mono16", "bgr8", "bgr16", "bgra8", "bgra16",
                                        "8UC1",  "8UC3",   "8UC4", "16UC1", "16UC3", "16UC4"};
  for (const std::string& encoding : kSupported) {
    SCOPED_TRACE(encoding);
    namespace enc = sensor_msgs::image_encodings;
    cv::Mat image(60, 80,
                  CV_MAKETYPE(enc::bitDepth(encoding) == 16 ? CV_16U : CV_8U, enc::numChannels(encoding)));
    cv::RNG(5).fill(image, cv::RNG::UNIFORM, 0, 65536);
    const sensor_msgs::ImageConstPtr msg = imageMsg(encoding, image);
    const cv::Mat few = fromMsgForFeatures(msg)->image;
    EXPECT_EQ(few.data == msg->data.data(), shared.count(encoding) == 1);
    const cv::Mat grey = core::toGrey(few, 1, buffer).clone();
    EXPECT_EQ(cv::norm(grey, core::toGrey(fromMsg(msg)->image, 1, buffer), cv::NORM_INF), 0);
    if (image.depth() != CV_16U) continue;
    const auto big = boost::make_shared<sensor_msgs::Image>(*msg);
    big->is_bigendian = 1;
    for (std::size_t i = 0; i < big->data.size(); i += 2) std::swap(big->data[i], big->data[i + 1]);
    const cv_bridge::CvImageConstPtr swapped = fromMsgForFeatures(sensor_msgs::ImageConstPtr(big));
    EXPECT_EQ(cv::norm(grey, core::toGrey(swapped->image, 1, buffer), cv::NORM_INF), 0);
  }
  expectRefused([] { fromMsgForFeatures(imageMsg("32FC1", cv::Mat(3, 5, CV_32FC1, cv::Scalar(1)))); },
                "32FC1");
  const auto cut =
      boost::make_shared<sensor_msgs::Image>(*imageMsg("mono16", cv::Mat(6, 8, CV_16U, cv::Scalar(1))));
  cut->data.pop_back();
  expectRefused([&] { fromMsgForFeatures(sensor_msgs::ImageConstPtr(cut)); }, "expected 96 bytes");
}

/// An image filled with one value, of the size in its header.
boost::shared_ptr<sensor_msgs::Image> blankMsg(const std::string& encoding, std::uint32_t width,
                                               std::uint32_t height) {
  namespace enc = sensor_msgs::image_encodings;
  const auto msg = boost::make_shared<sensor_msgs::Image>();
  msg->encoding = encoding;
  msg->width = width;
  msg->height = height;
  msg->step = width * static_cast<std::uint32_t>(enc::numChannels(encoding) * enc::bitDepth(encoding) / 8);
  msg->data.assign(static_cast<std::size_t>(msg->step) * height, 128);
  return msg;
}

TEST(ImageMessage, EveryEncodingInEverySmallSizeIsConvertedOrRefused) {
  for (const std::string& encoding : kSupported) {
    for (std::uint32_t width = 1; width < 6; ++width) {
      for (std::uint32_t height = 1; height < 6; ++height) {
        try {
          const cv::Mat image = fromMsg(sensor_msgs::ImageConstPtr(blankMsg(encoding, width, height)))->image;
          EXPECT_EQ(image.size(), cv::Size(static_cast<int>(width), static_cast<int>(height))) << encoding;
          EXPECT_TRUE(image.type() == CV_8UC1 || image.type() == CV_8UC3) << encoding;
        } catch (const std::invalid_argument& error) {
          EXPECT_NE(std::string(error.what()).find(encoding), std::string::npos) << error.what();
          EXPECT_TRUE(encoding == "yuv422" || width < 3 || height < 3) << error.what();
        }
      }
    }
  }
}

TEST(ImageMessage, HeadersThatLieAreRefusedInEveryEncoding) {
  for (const std::string& encoding : kSupported) {
    const auto with = [&encoding](const std::function<void(sensor_msgs::Image&)>& damage) {
      const auto msg = blankMsg(encoding, 8, 6);
      damage(*msg);
      return [msg] { fromMsg(sensor_msgs::ImageConstPtr(msg)); };
    };
    const std::string size = encoding + "', ";
    expectRefused(with([](sensor_msgs::Image& m) { m.data.clear(); }), size + "8x6");
    expectRefused(with([](sensor_msgs::Image& m) { m.data.pop_back(); }), size + "8x6");
    expectRefused(with([](sensor_msgs::Image& m) { m.data.push_back(0); }), size + "8x6");
    expectRefused(with([](sensor_msgs::Image& m) { m.width = 0; }), "no pixels");
    expectRefused(with([](sensor_msgs::Image& m) { m.height = 0; }), "no pixels");
    expectRefused(with([](sensor_msgs::Image& m) {
                    m = sensor_msgs::Image(m);
                    m.width = m.height = m.step = 0;
                    m.data.clear();
                  }),
                  "no pixels");
    expectRefused(with([](sensor_msgs::Image& m) { m.step = 0; }), "step 0");
    expectRefused(with([](sensor_msgs::Image& m) { --m.step; }), "step");
    expectRefused(with([](sensor_msgs::Image& m) { m.step = 0xffffffffu; }), "step 4294967295");
    expectRefused(with([](sensor_msgs::Image& m) { m.width = 9; }), "9x6");
    expectRefused(with([](sensor_msgs::Image& m) { m.height = 7; }), "8x7");
    expectRefused(with([](sensor_msgs::Image& m) { m.width = m.height = 0xffffffffu; }), "too large");
    expectRefused(with([](sensor_msgs::Image& m) { m.width = 0x80000000u; }), "too large");
    // Step times height is 2^32, nothing in 32 bits.
    expectRefused(with([](sensor_msgs::Image& m) {
                    m.height = 0x10000u;
                    m.step = 0x10000u;
                    m.data.clear();
                  }),
                  "4294967296");
  }
}

TEST(ImageMessage, OtherEncodingsAreNamed) {
  for (const char* encoding : {"", "8UC2", "8SC1", "16SC1", "32SC1", "32FC1", "64FC4", "8UC", "8UC5", "8UC-1",
                               "8UC99999999999", "nv12", "yuv422_yuy2", "MONO8"}) {
    const auto msg = boost::make_shared<sensor_msgs::Image>();
    msg->encoding = encoding;
    msg->width = msg->height = msg->step = 4;
    msg->data.resize(16);
    expectRefused([&] { fromMsg(sensor_msgs::ImageConstPtr(msg)); },
                  "encoding '" + std::string(encoding) + "' is not supported");
  }
}

TEST(CompressedImageMessage, IsDecoded) {
  sensor_msgs::CompressedImage msg;
  msg.format = "png";
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(3, 5, CV_8UC3, cv::Scalar(1, 2, 3)), msg.data));
  EXPECT_EQ(fromMsg(msg).type(), CV_8UC3);
  ASSERT_TRUE(cv::imencode(".png", cv::Mat(3, 5, CV_16UC1, cv::Scalar(65535)), msg.data));
  EXPECT_EQ(fromMsg(msg).at<std::uint8_t>(0, 0), 255);
}

// OpenCV fills the rows that are missing with whatever its memory holds.
TEST(CompressedImageMessage, CutOffDataAreRefused) {
  cv::Mat image(60, 80, CV_8UC3);
  cv::randu(image, 0, 256);
  for (const std::string format : {"jpg", "png"}) {
    sensor_msgs::CompressedImage whole;
    whole.format = format;
    ASSERT_TRUE(cv::imencode("." + format, image, whole.data));
    for (std::size_t kept = 0; kept < whole.data.size() - 1; kept += 101) {
      sensor_msgs::CompressedImage cut = whole;
      cut.data.resize(kept);
      expectRefused([&] { fromMsg(cut); }, format);
    }
    whole.data.resize(whole.data.size() + 100);  // some cameras pad
    EXPECT_EQ(fromMsg(whole).size(), image.size());
  }
}

TEST(CompressedImageMessage, GarbageIsNamed) {
  sensor_msgs::CompressedImage msg;
  msg.format = "strange";
  expectRefused([&] { fromMsg(msg); }, "strange");
  msg.data.assign(100, 42);
  expectRefused([&] { fromMsg(msg); }, "strange");
}

}  // namespace
}  // namespace corrsel
