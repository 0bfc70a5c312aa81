#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "selectors/parts/otsu.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

/// Between-class variance w0 w1 (m0 - m1)^2 of the split {v <= t}; -1 where a class is empty.
double separation(const std::vector<double>& values, double t) {
  double n0 = 0, n1 = 0, s0 = 0, s1 = 0;
  for (const double v : values) {
    (v <= t ? n0 : n1) += 1;
    (v <= t ? s0 : s1) += v;
  }
  if (n0 == 0 || n1 == 0) return -1;
  const double n = n0 + n1, difference = s0 / n0 - s1 / n1;
  return n0 / n * n1 / n * difference * difference;
}

/// Numbers in [low, high], most of them in two heaps, with repetitions.
std::vector<double> numbers(std::uint64_t seed, double low, double high) {
  Random random(seed);
  std::vector<double> values;
  const double first = random.uniform(0.1, 0.4), second = random.uniform(0.5, 0.9);
  for (std::size_t i = 0, n = 2 + random.index(300); i < n; ++i) {
    const double centre = random.index(3) == 0 ? first : second;
    const double share = std::clamp(centre + 0.08 * random.normal(), 0.0, 1.0);
    values.push_back(low + (high - low) * (i % 4 == 0 ? std::round(share * 10) / 10 : share));
  }
  return values;
}

TEST(Otsu, HistogramSplitIsTheBestOfAllBinEdges) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    for (const int bins : {2, 10, 256}) {
      const double low = seed % 2 ? 0 : -3, high = seed % 2 ? 1 : 5;
      const std::vector<double> values = numbers(seed, low, high);
      // Values in the middle of their bins have the same classes and the same variances but for the scale.
      const double width = (high - low) / bins, per_unit = bins / (high - low);
      std::vector<double> binned;
      for (const double v : values) {
        binned.push_back(low + (std::min(std::floor((v - low) * per_unit), bins - 1.0) + 0.5) * width);
      }
      double best = -1, expected = 0;
      for (int edge = 1; edge < bins; ++edge) {
        const double s = separation(binned, low + edge * width);
        if (s > best * (1 + 1e-12)) {
          best = s;
          expected = low + edge * width;
        }
      }
      const auto threshold = otsuThreshold(values, low, high, bins);
      ASSERT_EQ(threshold.has_value(), best >= 0);
      if (threshold) {
        EXPECT_NEAR(*threshold, expected, 1e-9) << "seed " << seed << ", " << bins << " bins";
      }
    }
  }
}

TEST(Otsu, AgreesWithOpenCvOnBytes) {
  Random random(9);
  cv::Mat image(1, 500, CV_8U);
  std::vector<double> values;
  for (int i = 0; i < image.cols; ++i) {
    const double grey = std::clamp((i % 3 ? 60 : 180) + 20 * random.normal(), 0.0, 255.0);
    image.at<std::uint8_t>(0, i) = static_cast<std::uint8_t>(grey);
    values.push_back(image.at<std::uint8_t>(0, i));
  }
  // OpenCV's t puts {v <= t} into the lower class; ours is the upper edge of that bin.
  cv::Mat split;
  EXPECT_EQ(*otsuThreshold(values, 0, 256, 256), cv::threshold(image, split, 0, 255, cv::THRESH_OTSU) + 1);
}

TEST(Otsu, SplitsTwoHeapsBetweenThem) {
  const std::vector<double> values = {0.1, 0.2, 0.2, 0.8, 0.9};
  // Of all edges in the gap the lowest: the upper side of the bin that holds 0.2.
  EXPECT_DOUBLE_EQ(*otsuThreshold(values, 0, 1, 256), 52.0 / 256);
}

TEST(Otsu, TakesTheLowestOfEqualSplits) {
  EXPECT_DOUBLE_EQ(*otsuThreshold({0.125, 0.375, 0.625}, 0, 1, 4), 0.25);
}

TEST(Otsu, IsUndefinedWhereOneClassIsAll) {
  EXPECT_FALSE(otsuThreshold({}, 0, 1, 256));
  EXPECT_FALSE(otsuThreshold({0.5}, 0, 1, 256));
  EXPECT_FALSE(otsuThreshold({0.5, 0.5, 0.5}, 0, 1, 256));
  EXPECT_FALSE(otsuThreshold({1, 1}, 0, 1, 256));
  EXPECT_FALSE(otsuThreshold({0.1, 0.9}, 1, 1, 256));
  EXPECT_FALSE(otsuThreshold({0.5, 0.501}, 0, 1, 256));  // one bin
  EXPECT_EQ(*otsuThreshold({0, 1}, 0, 1, 2), 0.5);
}

}  // namespace
}  // namespace corrsel::core
