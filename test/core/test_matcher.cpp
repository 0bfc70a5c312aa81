#include <gtest/gtest.h>

#include <limits>

#include "corrsel/features/matcher.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();

/// Features with the given descriptors; keypoint i is at (i, 2 i).
Features features(const cv::Mat& descriptors, const cv::Size& size = {640, 480}) {
  Features f;
  f.descriptors = descriptors;
  f.image_size = size;
  for (int i = 0; i < descriptors.rows; ++i) f.keypoints.emplace_back(float(i), float(2 * i), 5.0f);
  return f;
}

/// Random descriptors of small whole numbers: many equal distances.
cv::Mat randomDescriptors(int rows, int columns, int type, int values, std::uint64_t seed) {
  Random random(seed);
  cv::Mat d(rows, columns, type);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const std::uint32_t value = random.index(std::uint32_t(values));
      if (type == CV_8U) {
        d.at<std::uint8_t>(r, c) = std::uint8_t(value);
      } else {
        d.at<float>(r, c) = float(value);
      }
    }
  }
  return d;
}

double distance(const cv::Mat& a, int i, const cv::Mat& b, int j) {
  double sum = 0;
  for (int c = 0; c < a.cols; ++c) {
    if (a.type() == CV_8U) {
      for (int bits = a.at<std::uint8_t>(i, c) ^ b.at<std::uint8_t>(j, c); bits; bits &= bits - 1) ++sum;
    } else {
      sum += std::pow(double(a.at<float>(i, c)) - b.at<float>(j, c), 2);
    }
  }
  return a.type() == CV_8U ? sum : std::sqrt(sum);
}

TEST(Matcher, FindsTheTwoNearest) {
  struct Case {
    int type, columns, values;
  };
  for (const Case& c : {Case{CV_32F, 128, 256},
                        {CV_32F, 4, 3},
                        {CV_32F, 1, 5},
                        {CV_8U, 32, 256},
                        {CV_8U, 2, 3},
                        {CV_8U, 61, 2}}) {
    const cv::Mat left = randomDescriptors(70, c.columns, c.type, c.values, 1);
    const cv::Mat right = randomDescriptors(90, c.columns, c.type, c.values, 2);
    const Correspondences m = matchFeatures(features(left, {640, 480}), features(right, {320, 240}));
    ASSERT_EQ(m.size(), 70u);
    EXPECT_EQ(m.inconsistency(), "");
    EXPECT_EQ(m.left_size, cv::Size(640, 480));
    EXPECT_EQ(m.right_size, cv::Size(320, 240));
    for (int i = 0; i < 70; ++i) {
      const std::size_t row = std::size_t(i);
      double first = INFINITY, second = INFINITY;
      int best = -1;
      for (int j = 0; j < 90; ++j) {
        const double d = distance(left, i, right, j);
        if (d < first) {  // strictly: the lowest index of equals
          second = first;
          first = d;
          best = j;
        } else {
          second = std::min(second, d);
        }
      }
      EXPECT_EQ(m.left_index[row], std::uint32_t(i));
      EXPECT_EQ(m.right_index[row], std::uint32_t(best)) << c.type << " " << c.values << " row " << i;
      EXPECT_FLOAT_EQ(m.distance[row], float(first));
      EXPECT_FLOAT_EQ(m.second_distance[row], float(second));
      EXPECT_EQ(m.left_x[row], float(i));
      EXPECT_EQ(m.left_y[row], float(2 * i));
      EXPECT_EQ(m.right_x[row], float(best));
      EXPECT_EQ(m.right_y[row], float(2 * best));
    }
    EXPECT_TRUE(m.left_frame.empty() && m.right_frame.empty());
  }
}

TEST(Matcher, DoesNotDependOnOpenCvsThreads) {
  const Features left = features(randomDescriptors(300, 3, CV_32F, 4, 3));
  const Features right = features(randomDescriptors(300, 3, CV_32F, 4, 4));
  const int before = cv::getNumThreads();
  cv::setNumThreads(1);
  const Correspondences one = matchFeatures(left, right);
  cv::setNumThreads(2);
  const Correspondences two = matchFeatures(left, right);
  cv::setNumThreads(before);
  EXPECT_EQ(one.right_index, two.right_index);
  EXPECT_EQ(one.second_distance, two.second_distance);
}

TEST(Matcher, OneRightFeatureHasNoSecond) {
  for (const int type : {CV_32F, CV_8U}) {
    const Correspondences m = matchFeatures(features(randomDescriptors(3, 8, type, 9, 1)),
                                            features(randomDescriptors(1, 8, type, 9, 2)));
    ASSERT_EQ(m.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(m.right_index[i], 0u);
      EXPECT_TRUE(std::isnan(m.second_distance[i]));
    }
  }
}

TEST(Matcher, EmptySidesGiveNoMatches) {
  const Features some = features(randomDescriptors(3, 8, CV_32F, 9, 1)), none = features({}, {20, 10});
  for (const auto& [left, right] : {std::pair(some, none), std::pair(none, some), std::pair(none, none)}) {
    const Correspondences m = matchFeatures(left, right);
    EXPECT_TRUE(m.empty());
    EXPECT_EQ(m.left_size, left.image_size);
    EXPECT_EQ(m.right_size, right.image_size);
  }
}

TEST(Matcher, RefusesDescriptorsThatDiffer) {
  const auto refusal = [](const cv::Mat& left, const cv::Mat& right) {
    return errorOf<std::invalid_argument>([&] { matchFeatures(features(left), features(right)); });
  };
  const cv::Mat floats = cv::Mat::zeros(2, 8, CV_32F), bytes = cv::Mat::zeros(2, 8, CV_8U);
  EXPECT_EQ(refusal(floats, bytes), "descriptors differ: left 8 x CV_32FC1, right 8 x CV_8UC1");
  EXPECT_EQ(refusal(bytes, cv::Mat::zeros(2, 9, CV_8U)),
            "descriptors differ: left 8 x CV_8UC1, right 9 x CV_8UC1");
  EXPECT_EQ(refusal(cv::Mat::zeros(2, 8, CV_64F), cv::Mat::zeros(2, 8, CV_64F)),
            "descriptors are 8 x CV_64FC1; needed: CV_8U or CV_32F");
}

TEST(Matcher, DescriptorsWithNaNHaveNoNeighbour) {
  cv::Mat left = (cv::Mat_<float>(3, 2) << 0, 0, kNaN, 0, 5, 5);
  cv::Mat right = (cv::Mat_<float>(4, 2) << kNaN, kNaN, 0, 3, 5, kNaN, 5, 1);
  const Correspondences m = matchFeatures(features(left), features(right));
  EXPECT_EQ(m.inconsistency(), "");
  EXPECT_EQ(m.left_index, (std::vector<std::uint32_t>{0, 2}));
  EXPECT_EQ(m.right_index, (std::vector<std::uint32_t>{1, 3}));
  EXPECT_EQ(m.distance, (std::vector<float>{3, 4}));
  EXPECT_FLOAT_EQ(m.second_distance[0], std::sqrt(26.0f));
  EXPECT_FLOAT_EQ(m.second_distance[1], std::sqrt(29.0f));
  // Only one right descriptor is left, or none.
  right.at<float>(1, 0) = kNaN;
  EXPECT_TRUE(std::isnan(matchFeatures(features(left), features(right)).second_distance[0]));
  right.setTo(kNaN);
  EXPECT_TRUE(matchFeatures(features(left), features(right)).empty());
}

TEST(Matcher, TakesFramesWhereBothSidesHaveThem) {
  Features left = features((cv::Mat_<float>(2, 1) << 10, 20)),
           right = features((cv::Mat_<float>(2, 1) << 21, 11));
  left.frames = {AffineFrame{1}, AffineFrame{2}};
  EXPECT_TRUE(matchFeatures(left, right).left_frame.empty());
  right.frames = {AffineFrame{3}, AffineFrame{4}};
  const Correspondences m = matchFeatures(left, right);
  EXPECT_EQ(m.left_frame, (std::vector<AffineFrame>{{1}, {2}}));
  EXPECT_EQ(m.right_frame, (std::vector<AffineFrame>{{4}, {3}}));
}

}  // namespace
}  // namespace corrsel::core
