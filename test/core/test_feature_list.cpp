#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <vector>

#include "features/parts/feature_list.h"
#include "features/parts/spread.h"

namespace corrsel::core {
namespace {

constexpr int kCount = 300;
const cv::Size kSize(100, 80);

/// Features whose frames and descriptors hold their number. Many responses are equal, and some keypoints are.
Features numbered() {
  Features features;
  cv::RNG random(3);
  features.descriptors.create(kCount, 2, CV_32F);
  for (int i = 0; i < kCount; ++i) {
    const auto response = float(random.uniform(0, 6)), y = float(random.uniform(0, 4) * 20);
    const auto x = float(random.uniform(0, kSize.width));
    features.keypoints.emplace_back(x, y, 3.0F, 0.0F, response);
    if (i % 50 == 0) features.keypoints.back() = {5, 6, 7, 0, 3};
    features.frames.push_back({1, 0, float(i), 0, 1, 0});
    features.descriptors.row(i).setTo(i);
  }
  return features;
}

int numberOf(const Features& features, std::size_t i) { return int(features.frames[i][2]); }

void expectWhole(const Features& features, std::size_t count) {
  const Features all = numbered();
  ASSERT_EQ(features.keypoints.size(), count);
  ASSERT_EQ(features.frames.size(), count);
  ASSERT_EQ(features.descriptors.rows, int(count));
  for (std::size_t i = 0; i < count; ++i) {
    EXPECT_EQ(features.keypoints[i].pt, all.keypoints[std::size_t(numberOf(features, i))].pt);
    EXPECT_EQ(features.descriptors.at<float>(int(i), 1), float(numberOf(features, i)));
  }
}

TEST(FeatureList, TheStrongestAreKeptInOrder) {
  Features all = numbered();
  keepStrongest(0, false, kSize, all);
  expectWhole(all, kCount);
  for (std::size_t i = 1; i < kCount; ++i) {
    EXPECT_FALSE(stronger(all.keypoints[i], all.keypoints[i - 1]));
    // Of equal keypoints the one with the lower number comes first.
    if (!stronger(all.keypoints[i - 1], all.keypoints[i])) {
      EXPECT_LT(numberOf(all, i - 1), numberOf(all, i));
    }
  }
  for (const int most : {1, 40, kCount - 1, kCount, kCount + 1}) {
    Features some = numbered();
    keepStrongest(most, false, kSize, some);
    expectWhole(some, std::size_t(std::min(most, kCount)));
    for (std::size_t i = 0; i < some.keypoints.size(); ++i) EXPECT_EQ(numberOf(some, i), numberOf(all, i));
  }
}

TEST(FeatureList, SpreadKeepsTheStrongestOfEveryPart) {
  Features all = numbered(), some = numbered();
  keepStrongest(0, true, kSize, all);
  keepStrongest(60, true, kSize, some);
  expectWhole(all, kCount);
  expectWhole(some, 60);
  std::vector<cv::Point2f> points;
  for (const cv::KeyPoint& keypoint : all.keypoints) points.push_back(keypoint.pt);
  const std::vector<std::size_t> kept = spreadOverImage(points, kSize, 60);
  for (std::size_t i = 0; i < 60; ++i) EXPECT_EQ(numberOf(some, i), numberOf(all, kept[i]));
}

TEST(FeatureList, ASecondCallChangesNothing) {
  for (const bool spread : {false, true}) {
    Features once = numbered();
    keepStrongest(60, spread, kSize, once);
    Features twice = once;
    keepStrongest(60, spread, kSize, twice);
    EXPECT_EQ(twice.frames, once.frames);
    EXPECT_EQ(cv::norm(twice.descriptors, once.descriptors, cv::NORM_INF), 0);
  }
}

}  // namespace
}  // namespace corrsel::core
