#include <gtest/gtest.h>

#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/matching/match_mask.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

/// The pixels that a mask excludes, by a rule.
template <class Rule>
bool excludesExactly(const cv::Mat& mask, const Rule& rule) {
  if (mask.type() != CV_8UC1) return false;
  for (int y = 0; y < mask.rows; ++y) {
    for (int x = 0; x < mask.cols; ++x) {
      if ((mask.at<std::uint8_t>(y, x) == 0) != rule(x, y)) return false;
    }
  }
  return true;
}

TEST(MatchMask, ZeroExcludesInMasksOfEightAndSixteenBits) {
  for (const int type : {CV_8UC1, CV_16UC1}) {
    cv::Mat image(20, 30, type, cv::Scalar(type == CV_8UC1 ? 1 : 60000));
    image(cv::Rect(3, 4, 5, 6)).setTo(0);
    EXPECT_TRUE(excludesExactly(toMask(image), [](int x, int y) {
      return cv::Rect(3, 4, 5, 6).contains({x, y});
    }));
  }
}

TEST(MatchMask, ListedClassesAreExcludedInLabelImages) {
  for (const int type : {CV_8UC1, CV_16UC1}) {
    cv::Mat labels(20, 30, type);
    for (int x = 0; x < labels.cols; ++x) labels.col(x).setTo(x);
    MaskOptions options;
    options.classes = {11, 13, 60000};  // 8 bits have no label 60000
    EXPECT_TRUE(excludesExactly(toMask(labels, options), [](int x, int) { return x == 11 || x == 13; }));
    options.classes = {0};
    EXPECT_TRUE(excludesExactly(toMask(labels, options), [](int x, int) { return x == 0; }));
  }
}

TEST(MatchMask, DilationWidensWhatIsExcluded) {
  cv::Mat labels = cv::Mat::zeros(40, 60, CV_8UC1);
  labels(cv::Rect(20, 10, 5, 6)).setTo(7);
  labels.at<std::uint8_t>(39, 59) = 7;  // at the edge of the image
  MaskOptions options;
  options.classes = {7};
  options.dilation = 3;
  EXPECT_TRUE(excludesExactly(toMask(labels, options), [](int x, int y) {
    return cv::Rect(17, 7, 11, 12).contains({x, y}) || (x >= 56 && y >= 36);
  }));
}

TEST(MatchMask, AnImageOfAnotherTypeIsRefusedByName) {
  for (const int type : {CV_8UC3, CV_32FC1, CV_16SC1}) {
    try {
      toMask(cv::Mat(4, 4, type, cv::Scalar(0)));
      ADD_FAILURE() << cv::typeToString(type);
    } catch (const std::invalid_argument& error) {
      EXPECT_TRUE(testing::contains(error.what(), "mask has type " + cv::typeToString(type))) << error.what();
    }
  }
}

TEST(MatchMask, AMaskOfTheSameShapeIsScaledAndAnyOtherIsRefused) {
  cv::Mat mask(120, 160, CV_8UC1, cv::Scalar(255));
  mask.colRange(0, 40).setTo(0);
  EXPECT_EQ(fittedMask(mask, mask.size()).data, mask.data) << "no copy";
  EXPECT_EQ(fittedMask(mask, cv::Size()).data, mask.data) << "a size that is not known";
  EXPECT_TRUE(excludesExactly(fittedMask(mask, {640, 480}), [](int x, int) { return x < 160; }));
  EXPECT_EQ(fittedMask(mask, {640, 480}).size(), cv::Size(640, 480));
  EXPECT_EQ(fittedMask(cv::Mat(188, 620, CV_8UC1), {1241, 376}).size(), cv::Size(1241, 376))
      << "half of an odd width, rounded";
  for (const cv::Size size : {cv::Size(640, 360), cv::Size(480, 640), cv::Size(10, 10)}) {
    try {
      fittedMask(mask, size);
      ADD_FAILURE() << size;
    } catch (const std::invalid_argument& error) {
      EXPECT_TRUE(
          testing::contains(error.what(), "mask has 160x120 px; needed: " + std::to_string(size.width) + "x"))
          << error.what();
    }
  }
}

TEST(MatchMask, RowsOnAZeroOfEitherMaskAreLeftOut) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  cv::Mat left(100, 100, CV_8UC1, cv::Scalar(255)), right = left.clone();
  left(cv::Rect(0, 0, 50, 100)).setTo(0);
  right(cv::Rect(0, 90, 100, 10)).setTo(0);
  Correspondences matches;
  matches.add({49.4F, 10}, {10, 10});      // 0: on the left mask
  matches.add({49.6F, 10}, {10, 10});      // 1
  matches.add({70, 10}, {10, 89.6F});      // 2: on the right mask
  matches.add({70, 10}, {10, 89.4F});      // 3
  matches.add({-0.4F, 10}, {10, 10});      // 4: the pixel at the edge counts
  matches.add({kNaN, 10}, {10, 10});       // 5: on no mask
  matches.add({70, 10}, {10, kInfinity});  // 6: on no mask
  matches.add({kNaN, 10}, {10, 95});       // 7: its other point is on a mask
  EXPECT_EQ(unmaskedRows(matches, left, right), (std::vector<std::uint32_t>{1, 3, 5, 6}));
  EXPECT_EQ(unmaskedRows(matches, left, {}), (std::vector<std::uint32_t>{1, 2, 3, 5, 6, 7}));
  EXPECT_EQ(unmaskedRows(matches, {}, right), (std::vector<std::uint32_t>{0, 1, 3, 4, 5, 6}));
  EXPECT_EQ(unmaskedRows(matches, {}, {}).size(), matches.size());
}

}  // namespace
}  // namespace corrsel::core
