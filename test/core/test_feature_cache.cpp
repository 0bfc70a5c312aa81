#include <gtest/gtest.h>

#include "benchmark/feature_cache.h"
#include "feature_checks.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

cv::Mat noise(std::uint64_t seed, cv::Size size = {160, 120}, int type = CV_8U) {
  Random random(seed);
  cv::Mat image(size, type);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols * image.channels(); ++x) image.ptr(y)[x] = std::uint8_t(random.index(256));
  }
  return image;
}

class FeatureCacheTest : public ::testing::Test {
 protected:
  /// Not vacuously.
  static void expectSame(const Features& a, const Features& b) {
    ASSERT_GT(a.keypoints.size(), 0u);
    testing::expectSame(a, b);
  }

  const std::unique_ptr<FeatureExtractor> extractor_ = createExtractor("orb+orb");
  FeatureCache cache_{std::size_t{64} << 20U};
};

TEST_F(FeatureCacheTest, ImagesThatComeAgainAreNotExtractedAgain) {
  const cv::Mat first = noise(1);
  for (int threads : {1, 2}) {
    for (std::uint64_t k = 2; k < 6; ++k) {
      const cv::Mat other = noise(k);
      const auto [left, right] = cache_.extractPair(*extractor_, first.clone(), other, threads);
      expectSame(*left, extractor_->extract(first));
      expectSame(*right, extractor_->extract(other));
    }
  }
  EXPECT_EQ(cache_.misses(), 5u);
  EXPECT_EQ(cache_.hits(), 11u);
}

TEST_F(FeatureCacheTest, OnePixelMakesAnotherImage) {
  const cv::Mat image = noise(1);
  cv::Mat changed = image.clone();
  changed.at<std::uint8_t>(119, 159) ^= 1U;
  cache_.extractPair(*extractor_, image, changed, 1);
  EXPECT_EQ(cache_.misses(), 2u);
  // The pixels alone do not make an image: the same bytes in another shape.
  cache_.extractPair(*extractor_, image.reshape(1, 160), image.reshape(1, 80), 1);
  EXPECT_EQ(cache_.misses(), 4u);
}

TEST_F(FeatureCacheTest, WidthsThatAreNoWholeWordsAreComparedToTheEnd) {
  const cv::Mat image = noise(1, {163, 120});
  for (int x = 155; x < 163; ++x) {
    cv::Mat changed = image.clone();
    changed.at<std::uint8_t>(60, x) ^= 128U;
    cache_.extractPair(*extractor_, image, changed, 1);
  }
  EXPECT_EQ(cache_.misses(), 9u);
}

TEST_F(FeatureCacheTest, ExtractorsAreToldApart) {
  const auto sift = createExtractor("sift+sift");
  const cv::Mat left = noise(1), right = noise(2);
  cache_.extractPair(*extractor_, left, right, 1);
  EXPECT_EQ(cache_.extractPair(*sift, left, right, 1).first->descriptors.cols, 128);
  EXPECT_EQ(cache_.extractPair(*extractor_, left, right, 1).first->descriptors.cols, 32);
  EXPECT_EQ(cache_.misses(), 4u);
}

TEST_F(FeatureCacheTest, TheCallersImageMayChange) {
  cv::Mat image = noise(1);
  const cv::Mat before = image.clone();
  cache_.extractPair(*extractor_, image, noise(2), 1);
  noise(3).copyTo(image);
  expectSame(*cache_.extractPair(*extractor_, image, before, 1).first, extractor_->extract(image));
}

TEST_F(FeatureCacheTest, StaysBelowItsBoundAndKeepsWhatWasUsedLast) {
  const std::size_t one = [&] {
    FeatureCache cache(std::size_t{64} << 20U);
    cache.extractPair(*extractor_, noise(1), noise(1), 1);
    return cache.bytes();
  }();
  FeatureCache cache(3 * one + one / 2);
  const cv::Mat first = noise(1);
  for (std::uint64_t k = 2; k < 30; ++k) {
    cache.extractPair(*extractor_, first, noise(k), 1);
    EXPECT_LE(cache.bytes(), 3 * one + one / 2);
  }
  EXPECT_EQ(cache.hits(), 27u);  // the first image, every time but one
  EXPECT_GT(cache.bytes(), one);
}

TEST_F(FeatureCacheTest, ImagesLargerThanTheBoundAreNotKept) {
  for (const std::size_t bound : {0, 1000}) {
    FeatureCache cache(bound);
    for (int k = 0; k < 2; ++k) cache.extractPair(*extractor_, noise(1), noise(2), 1);
    EXPECT_EQ(cache.bytes(), 0u);
    EXPECT_EQ(cache.misses(), 4u);
  }
}

TEST_F(FeatureCacheTest, ErrorsLeaveItAsItWas) {
  const cv::Mat image = noise(1), bad(10, 10, CV_32F, cv::Scalar(0));
  EXPECT_TRUE(contains(
      errorOf<std::invalid_argument>([&] { cache_.extractPair(*extractor_, image, bad, 2); }), "CV_32FC1"));
  EXPECT_EQ(errorOf<std::invalid_argument>([&] { cache_.extractPair(*extractor_, {}, image, 1); }),
            "image is empty");
  expectSame(*cache_.extractPair(*extractor_, image, image, 1).second, extractor_->extract(image));
}

}  // namespace
}  // namespace corrsel::core
