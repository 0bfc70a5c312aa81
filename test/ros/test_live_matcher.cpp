#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "corrsel/random.h"
#include "corrsel/ros/cameras.h"
#include "corrsel/ros/conversions.h"
#include "ros/live/live_matcher.h"

namespace corrsel {
namespace {

constexpr int kWidth = 320, kHeight = 240;

/// A wide strip of corners; views are cut out of it.
cv::Mat strip() {
  core::Random random(3);
  cv::Mat image(kHeight, 4 * kWidth, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 900; ++i) {
    const auto y = static_cast<int>(random.index(kHeight));
    const auto x = static_cast<int>(random.index(4 * kWidth));
    const cv::Point corner(x, y);
    const int size = 4 + static_cast<int>(random.index(20));
    cv::rectangle(image, cv::Rect(corner, cv::Size(size, size)), cv::Scalar(random.index(256)), cv::FILLED);
  }
  return image;
}

sensor_msgs::ImageConstPtr message(const cv::Mat& image, double stamp, const std::string& frame = "camera") {
  std_msgs::Header header;
  header.stamp.fromSec(stamp);
  header.frame_id = frame;
  return cv_bridge::CvImage(header, image.channels() == 1 ? "mono8" : "bgr8", image).toImageMsg();
}

/// Of one camera of a rectified rig.
/// @param baseline  m
CalibrationPtr calibration(double focal_length, double baseline = 0) {
  core::Camera camera;
  camera.matrix = {focal_length, 0, kWidth / 2.0, 0, focal_length, kHeight / 2.0, 0, 0, 1};
  camera.size = {kWidth, kHeight};
  Calibration result{cameraInfo(camera), true, camera};
  result.info.P[3] = -focal_length * baseline;
  return std::make_shared<const Calibration>(result);
}

class LiveMatcherTest : public ::testing::Test {
 protected:
  LiveMatcherTest() {
    settings_.extractor = core::createExtractor("orb+orb", {{"orb", {{"max_features", "300"}}}});
  }

  /// What the camera sees `shift` px along the strip.
  cv::Mat view(int shift) const { return strip_(cv::Rect(shift, 0, kWidth, kHeight)).clone(); }

  boost::shared_ptr<Correspondences> frame(int shift, double stamp) {
    ImageSet images;
    images.left = message(view(shift), stamp);
    return matcher_.match(images, settings_);
  }

  const cv::Mat strip_ = strip();
  LiveMatcher::Settings settings_;
  LiveMatcher matcher_{LiveMatcher::Setup{2}};
};

TEST_F(LiveMatcherTest, PairsAreMatchedAsTheCoreDoes) {
  ImageSet images;
  images.left = message(view(0), 10.0, "left_optical");
  images.right = message(view(30), 10.001, "right_optical");
  const auto answer = matcher_.match(images, settings_);
  ASSERT_TRUE(answer);
  const auto features = core::extractPair(*settings_.extractor, view(0), view(30), 1);
  const core::Correspondences expected = core::matchFeatures(features.first, features.second, {});
  ASSERT_GT(expected.size(), 100u);
  const core::Correspondences actual = fromMsg(*answer);
  EXPECT_EQ(actual.left_x, expected.left_x);
  EXPECT_EQ(actual.right_y, expected.right_y);
  EXPECT_EQ(actual.right_index, expected.right_index);
  EXPECT_EQ(answer->header.stamp, ros::Time(10.0));
  EXPECT_EQ(answer->header.frame_id, "left_optical");
  EXPECT_EQ(answer->right_stamp, images.right->header.stamp);
  EXPECT_EQ(answer->right_frame_id, "right_optical");
  EXPECT_EQ(answer->features, "orb+orb");
  EXPECT_EQ(answer->n_left_features, features.first.keypoints.size());
  for (const double seconds : {answer->seconds.wait, answer->seconds.detect, answer->seconds.describe,
                               answer->seconds.match, answer->seconds.publish}) {
    EXPECT_GE(seconds, 0.0);
    EXPECT_LT(seconds, 60.0);
  }
}

TEST_F(LiveMatcherTest, PairsHaveTheCamerasAndThePoseBetweenThem) {
  ImageSet images;
  images.left = message(view(0), 1.0);
  images.right = message(view(30), 1.0);
  PairInfo info;
  const auto answer = [&] { return fromMsg(*matcher_.match(images, settings_), &info); };
  const core::Correspondences without = answer();
  EXPECT_FALSE(without.left_camera || without.right_camera || info.rig);
  images.left_calibration = calibration(300);
  const core::Correspondences half = answer();
  EXPECT_EQ(half.left_camera, images.left_calibration->camera);
  EXPECT_FALSE(half.right_camera || info.rig);
  images.right_calibration = calibration(310);
  const core::Correspondences alone = answer();
  EXPECT_EQ(alone.right_camera, images.right_calibration->camera);
  EXPECT_FALSE(info.rig) << "they have no baseline";
  images.right_calibration = calibration(310, 0.12);
  const core::Correspondences together = answer();
  EXPECT_EQ(together.right_camera, images.right_calibration->camera);
  ASSERT_TRUE(info.rig);
  EXPECT_EQ(info.rig->rotation, cv::Matx33d::eye());
  EXPECT_LT(cv::norm(info.rig->translation - cv::Vec3d(-0.12, 0, 0)), 1e-12);
  EXPECT_EQ(together.left_x, without.left_x);
}

TEST_F(LiveMatcherTest, FramesOfASequenceHaveTheCameraThatTheyWereTakenWith) {
  const auto answer = [&](const CalibrationPtr& of_frame, double stamp) {
    ImageSet images;
    images.left = message(view(static_cast<int>(10 * stamp)), stamp);
    images.left_calibration = of_frame;
    return matcher_.match(images, settings_);
  };
  const CalibrationPtr wide = calibration(300, 0.12), tele = calibration(600, 0.12);
  EXPECT_FALSE(answer(wide, 1.0));
  PairInfo info;
  const core::Correspondences zoomed = fromMsg(*answer(tele, 2.0), &info);
  EXPECT_EQ(zoomed.left_camera, tele->camera);
  EXPECT_EQ(zoomed.right_camera, wide->camera);
  EXPECT_FALSE(info.rig) << "it is one camera";
  const core::Correspondences lost = fromMsg(*answer(nullptr, 3.0));
  EXPECT_FALSE(lost.left_camera);
  EXPECT_EQ(lost.right_camera, tele->camera);
}

TEST_F(LiveMatcherTest, ImagesOfTwelveBitsAreStretchedHoweverDarkTheNextOnesAre) {
  const auto deep = [this](int shift, double scale, double stamp) {
    cv::Mat pixels;
    view(shift).convertTo(pixels, CV_16U, scale);
    return cv_bridge::CvImage(message(view(shift), stamp)->header, "mono16", pixels).toImageMsg();
  };
  const auto features = core::extractPair(*settings_.extractor, view(0), view(30), 1);
  const auto pair = [&](double scale, double stamp) {
    ImageSet images;
    images.left = deep(0, scale, stamp);
    images.right = deep(30, scale, stamp);
    return matcher_.match(images, settings_);
  };
  double largest = 0;
  cv::minMaxLoc(view(0), nullptr, &largest);
  ASSERT_GT(largest, 128);
  const auto bright = pair(4095.0 / 255, 1.0);
  EXPECT_EQ(bright->n_left_features, features.first.keypoints.size());
  EXPECT_EQ(fromMsg(*bright).left_x, core::matchFeatures(features.first, features.second, {}).left_x);
  // Values up to 1000 would be stretched to 255 if they came first, and are 64 of 255 now.
  const auto dark = pair(4.0, 2.0);
  cv::Mat expected;
  view(0).convertTo(expected, CV_16U, 4.0);
  expected.convertTo(expected, CV_8U, 255.0 / 4095);
  EXPECT_EQ(dark->n_left_features, settings_.extractor->extract(expected).keypoints.size());
}

TEST_F(LiveMatcherTest, MessagesHaveWhatTheImagesSufferFrom) {
  cv::Mat dark, blurred;
  view(30).convertTo(dark, CV_8U, 0.02);
  cv::GaussianBlur(view(0), blurred, {0, 0}, 2.5);
  const auto pair = [&](LiveMatcher& matcher) {
    ImageSet images;
    images.left = message(blurred, 1.0);
    images.right = message(dark, 1.0);
    return matcher.match(images, settings_);
  };
  const auto answer = pair(matcher_);
  EXPECT_NEAR(answer->left_quality.blur, 2.5, 0.8);
  EXPECT_EQ(answer->left_quality.relative_blur, 1);
  EXPECT_LT(answer->left_quality.black, 0.2);
  EXPECT_EQ(answer->right_quality.black, 1);
  EXPECT_EQ(answer->right_quality.texture, 0);
  LiveMatcher without(LiveMatcher::Setup{2, false});
  const auto unmeasured = pair(without);
  EXPECT_TRUE(std::isnan(unmeasured->left_quality.blur) && std::isnan(unmeasured->right_quality.black));
  EXPECT_EQ(unmeasured->left_quality.texture, answer->left_quality.texture);
}

TEST_F(LiveMatcherTest, TheQualityOfAnEarlierImageGoesWithIt) {
  ImageSet images;
  images.left = message(view(0), 1.0);
  matcher_.match(images, settings_);
  cv::Mat blurred;
  cv::GaussianBlur(view(10), blurred, {0, 0}, 2.5);
  images.left = message(blurred, 1.1);
  const auto answer = matcher_.match(images, settings_);
  ASSERT_TRUE(answer);
  EXPECT_GT(answer->left_quality.relative_blur, 2.5);
  EXPECT_EQ(answer->right_quality.relative_blur, 1);
  EXPECT_GT(answer->left_quality.blur, 2.5 * answer->right_quality.blur);
}

TEST_F(LiveMatcherTest, QualityIsThatOfThePartWhereFeaturesAreLookedFor) {
  cv::Mat half = view(0);
  half(cv::Rect(0, 0, kWidth / 2, kHeight)).setTo(0);
  ImageSet images;
  images.left = images.right = message(half, 1.0);
  settings_.area = cv::Rect(kWidth / 2, 0, 0, 0);
  EXPECT_LT(matcher_.match(images, settings_)->left_quality.black, 0.2);
  settings_.area = cv::Rect(0, 0, kWidth / 2, 0);
  EXPECT_EQ(matcher_.match(images, settings_)->left_quality.black, 1);
}

TEST_F(LiveMatcherTest, SequencesMatchTheNewImageOnTheLeftWithTheOneBefore) {
  EXPECT_FALSE(frame(0, 1.0));
  for (const double stamp : {2.0, 3.0}) {
    const auto answer = frame(static_cast<int>(stamp) * 20, stamp);
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->header.stamp, ros::Time(stamp));
    EXPECT_EQ(answer->right_stamp, ros::Time(stamp - 1));
    EXPECT_EQ(answer->right_frame_id, "camera");
    ASSERT_GT(answer->left_x.size(), 100u);
    std::size_t right = 0;  // the camera moves 20 px to the right: what it sees moves to the left
    const int shift = stamp == 2.0 ? 40 : 20;
    for (std::size_t i = 0; i < answer->left_x.size(); ++i) {
      right += std::abs(answer->right_x[i] - answer->left_x[i] - static_cast<float>(shift)) < 2 ? 1 : 0;
    }
    EXPECT_GT(right, answer->left_x.size() / 2) << "at " << stamp;
  }
}

TEST_F(LiveMatcherTest, SequencesMayLookFurtherBackOrAtKeyframes) {
  settings_.sequence.step = 2;
  EXPECT_FALSE(frame(0, 1.0));
  EXPECT_FALSE(frame(10, 2.0));
  EXPECT_EQ(frame(20, 3.0)->right_stamp, ros::Time(1.0));

  LiveMatcher other(LiveMatcher::Setup{1});
  matcher_.match({message(view(0), 4.0), nullptr, nullptr, nullptr, nullptr, nullptr, {}}, settings_);
  settings_.sequence.reference = core::SequenceOptions::Reference::kKeyframe;
  settings_.sequence.min_overlap = 0.5;
  const auto answer = [&](int shift, double stamp) {
    return other.match({message(view(shift), stamp), nullptr, nullptr, nullptr, nullptr, nullptr, {}},
                       settings_);
  };
  EXPECT_FALSE(answer(0, 1.0));
  EXPECT_EQ(answer(15, 2.0)->right_stamp, ros::Time(1.0));
  EXPECT_EQ(answer(30, 3.0)->right_stamp, ros::Time(1.0));
  EXPECT_EQ(answer(280, 4.0)->right_stamp, ros::Time(1.0));  // hardly anything is seen again
  EXPECT_EQ(answer(290, 5.0)->right_stamp, ros::Time(4.0));
}

TEST_F(LiveMatcherTest, SequencesBeginAnewWhereTheyMust) {
  EXPECT_FALSE(frame(0, 10.0));
  EXPECT_TRUE(frame(5, 11.0));
  EXPECT_FALSE(frame(10, 3.0));  // a bag that starts again
  EXPECT_TRUE(frame(10, 4.0));
  ImageSet larger;
  larger.left = message(cv::Mat(strip_(cv::Rect(0, 0, 2 * kWidth, kHeight))), 5.0);
  EXPECT_FALSE(matcher_.match(larger, settings_));  // another resolution
  EXPECT_FALSE(frame(10, 6.0));
  EXPECT_TRUE(frame(10, 7.0));
  settings_.extractor = core::createExtractor("orb+brisk");
  EXPECT_FALSE(frame(10, 8.0));  // descriptors of another kind
  EXPECT_EQ(frame(10, 9.0)->features, "orb+brisk");
}

TEST_F(LiveMatcherTest, FlowFollowsPointsInPlaceOfDescriptors) {
  settings_.flow = std::make_shared<core::FlowMatcher>();
  EXPECT_FALSE(frame(0, 1.0));
  const auto first = frame(6, 2.0), second = frame(12, 3.0);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(second->features, "orb+flow");
  EXPECT_EQ(second->right_stamp, ros::Time(2.0));
  EXPECT_TRUE(second->distance.empty());
  ASSERT_GT(second->left_x.size(), 100u);
  for (std::size_t i = 0; i < second->left_x.size(); ++i) {
    EXPECT_NEAR(second->right_x[i] - second->left_x[i], 6, 0.3);
    EXPECT_LT(second->left_index[i], second->n_left_features);
    // The right end of the match is the left end of the one before.
    const auto before = std::find(first->left_index.begin(), first->left_index.end(), second->right_index[i]);
    if (before == first->left_index.end()) continue;
    EXPECT_EQ(second->right_x[i],
              first->left_x[static_cast<std::size_t>(before - first->left_index.begin())]);
  }
  settings_.sequence.reference = core::SequenceOptions::Reference::kKeyframe;
  EXPECT_EQ(frame(18, 4.0)->right_stamp, ros::Time(3.0));
  EXPECT_EQ(frame(24, 5.0)->right_stamp, ros::Time(3.0));
}

TEST_F(LiveMatcherTest, FlowBeginsAnewWhereItMust) {
  settings_.flow = std::make_shared<core::FlowMatcher>();
  EXPECT_FALSE(frame(0, 10.0));
  EXPECT_TRUE(frame(5, 11.0));
  EXPECT_FALSE(frame(10, 3.0));  // a bag that starts again
  EXPECT_GT(frame(10, 4.0)->left_x.size(), 100u);
  settings_.flow = std::make_shared<core::FlowMatcher>();  // other options
  EXPECT_FALSE(frame(10, 5.0));
  EXPECT_TRUE(frame(10, 6.0));
  settings_.flow.reset();
  EXPECT_FALSE(frame(10, 7.0));
  EXPECT_EQ(frame(10, 8.0)->features, "orb+orb");
}

TEST_F(LiveMatcherTest, StampsThatStandStillAreNoReasonToStop) {
  EXPECT_FALSE(frame(0, 0.0));
  EXPECT_TRUE(frame(5, 0.0));
  EXPECT_TRUE(frame(10, 0.0));
}

TEST_F(LiveMatcherTest, MasksAndAreaLimitWhereFeaturesAre) {
  cv::Mat mask(kHeight, kWidth, CV_8UC1, cv::Scalar(255));
  mask.colRange(0, 160).setTo(0);
  ImageSet images;
  images.left = message(view(0), 1.0);
  images.right = message(view(0), 1.0);
  images.left_mask = message(mask, 0.0);
  cv::cvtColor(mask, mask, cv::COLOR_GRAY2BGR);  // as an image file may come
  images.right_mask = message(255 - mask, 0.0);
  settings_.area = cv::Rect(0, 60, 0, 100);  // all columns
  const auto answer = matcher_.match(images, settings_);
  ASSERT_GT(answer->left_x.size(), 10u);
  for (std::size_t i = 0; i < answer->left_x.size(); ++i) {
    EXPECT_GE(answer->left_x[i], 159.5F);
    EXPECT_LE(answer->right_x[i], 159.5F);
    for (const float y : {answer->left_y[i], answer->right_y[i]}) {
      EXPECT_GE(y, 59.5F);
      EXPECT_LE(y, 159.5F);
    }
  }
}

TEST_F(LiveMatcherTest, AFixedMaskCountsTogetherWithTheNewestOne) {
  cv::Mat body(kHeight / 2, kWidth / 2, CV_8UC1, cv::Scalar(255)),
      mask(kHeight, kWidth, CV_8UC1, cv::Scalar(1));
  body.colRange(0, 30).setTo(0);  // of a smaller image of the same shape
  mask.rowRange(0, 80).setTo(0);
  LiveMatcher matcher(LiveMatcher::Setup{1, true, nullptr, body});
  ImageSet images;
  images.left = message(view(0), 1.0);
  images.right = message(view(0), 1.0);
  const auto least = [&](auto member) {
    const auto answer = matcher.match(images, settings_);
    const std::vector<float>& values = (*answer).*member;
    return values.empty() ? std::nanf("") : *std::min_element(values.begin(), values.end());
  };
  EXPECT_GE(least(&Correspondences::left_x), 59.5F);
  EXPECT_LT(least(&Correspondences::left_y), 79.5F);
  EXPECT_LT(least(&Correspondences::right_x), 59.5F) << "the right camera has no fixed mask";
  images.left_mask = message(mask, 1.0);
  EXPECT_GE(least(&Correspondences::left_x), 59.5F);
  EXPECT_GE(least(&Correspondences::left_y), 79.5F);
  images.left_mask = message(255 - mask, 1.0);  // excludes nothing, because it is 255 or 254
  EXPECT_LT(least(&Correspondences::left_y), 79.5F);
}

TEST_F(LiveMatcherTest, WhatCannotBeUsedIsNamed) {
  const auto refused = [&](const ImageSet& images) {
    try {
      matcher_.match(images, settings_);
    } catch (const std::invalid_argument& error) {
      return std::string(error.what());
    }
    return std::string("accepted");
  };
  ImageSet images;
  images.left = message(view(0), 1.0);
  images.right = message(view(0), 1.0);
  images.left_mask = message(cv::Mat(10, 10, CV_8UC1, cv::Scalar(255)), 1.0);
  EXPECT_NE(refused(images).find("10"), std::string::npos) << refused(images);
  images.left_mask.reset();
  settings_.area = cv::Rect(1000, 0, 50, 50);
  EXPECT_NE(refused(images).find("1000"), std::string::npos) << refused(images);
  settings_.area = cv::Rect();
  EXPECT_TRUE(matcher_.match(images, settings_));
}

}  // namespace
}  // namespace corrsel
