#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "corrsel/features/extractor.h"
#include "feature_checks.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Stripes, discs and single pixels of zeros.
cv::Mat holes(const cv::Size& size, std::uint64_t seed = 1) {
  Random random(seed);
  const auto below = [&random](int bound) { return int(random.index(std::uint32_t(bound))); };
  cv::Mat mask(size, CV_8U, cv::Scalar(255));
  for (int i = 0; i < 10; ++i) {
    // Compilers evaluate arguments in different orders: whatever is drawn has a statement of its own.
    const int radius = 5 + below(25), x = below(size.width), y = below(size.height);
    cv::circle(mask, {x, y}, radius, 0, cv::FILLED);
  }
  for (int x = 7; x < size.width; x += 40) mask.col(x).setTo(0);
  for (int i = 0; i < size.area() / 50; ++i) {
    const int x = below(size.width), y = below(size.height);
    mask.at<std::uint8_t>(y, x) = 0;
  }
  return mask;
}

bool isMasked(const cv::Mat& mask, const cv::Point2f& at) {
  const int x = std::clamp(int(std::floor(at.x + 0.5F)), 0, mask.cols - 1);
  const int y = std::clamp(int(std::floor(at.y + 0.5F)), 0, mask.rows - 1);
  return mask.at<std::uint8_t>(y, x) == 0;
}

/// What is left of features when those on zeros are taken out.
Features masked(const Features& all, const cv::Mat& mask) {
  Features result;
  result.image_size = all.image_size;
  for (std::size_t i = 0; i < all.keypoints.size(); ++i) {
    if (isMasked(mask, all.keypoints[i].pt)) continue;
    result.keypoints.push_back(all.keypoints[i]);
    result.frames.push_back(all.frames[i]);
    result.descriptors.push_back(all.descriptors.row(int(i)));
  }
  return result;
}

/// Features of a part of an image in coordinates of the image.
Features moved(Features features, const cv::Point& by, const cv::Size& image) {
  features.image_size = image;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    features.keypoints[i].pt += cv::Point2f(by);
    features.frames[i][2] = features.keypoints[i].pt.x;
    features.frames[i][5] = features.keypoints[i].pt.y;
  }
  return features;
}

class Region : public ::testing::TestWithParam<std::string> {
 protected:
  std::unique_ptr<FeatureExtractor> create(const OptionMap& options = {{"max_features", "0"}}) const {
    AlgorithmOptions all = {{detector(), options}};
    if (detector() == "asift") all["asift"].insert({"tilts", "1"});
    return createExtractor(GetParam(), all);
  }
  std::string detector() const { return algorithmsOf(GetParam()).front(); }
  /// Descriptors of other detectors' keypoints may lose those near a border.
  bool onePass() const { return algorithmsOf(GetParam()).size() == 1; }
};

TEST_P(Region, TheWholeImageIsAsNone) {
  const cv::Mat image = shapes();
  const cv::Rect whole({0, 0}, image.size());
  const cv::Mat ones(image.size(), CV_8U, cv::Scalar(1));
  for (const OptionMap& options :
       {OptionMap{}, {{"max_features", "50"}}, {{"max_features", "50"}, {"spread", "true"}}}) {
    const auto extractor = create(options);
    const Features expected = extractor->extract(image);
    ASSERT_GT(expected.keypoints.size(), 20u);
    for (const FeatureRegion& region : std::vector<FeatureRegion>{
             {whole, {}},
             {{-20, -5, 1000, 1000}, {}},
             {{-1, -1, std::numeric_limits<int>::max(), std::numeric_limits<int>::max()}, {}},
             {{}, ones},
             {{}, 255 * ones},
             {whole, ones}}) {
      expectSame(extractor->extract(image, 2, region), expected);
    }
  }
}

TEST_P(Region, AnAreaIsAnImageOfItsOwn) {
  const cv::Mat image = shapes(3);
  const cv::Rect area(37, 31, 331, 260);
  for (const OptionMap& options : {OptionMap{{"max_features", "0"}},
                                   {{"max_features", "40"}},
                                   {{"max_features", "40"}, {"spread", "true"}}}) {
    const auto extractor = create(options);
    const Features expected = moved(extractor->extract(image(area)), area.tl(), image.size());
    ASSERT_GT(expected.keypoints.size(), 10u);
    const Features features = extractor->extract(image, 1, {area, {}});
    expectSame(features, expected);
    for (const cv::KeyPoint& k : features.keypoints) {
      EXPECT_TRUE(cv::Rect2f(area.x - 0.5F, area.y - 0.5F, 331, 260).contains(k.pt)) << k.pt;
    }
  }
}

TEST_P(Region, AnAreaIsCutToTheImage) {
  const cv::Mat image = shapes();
  const auto extractor = create();
  const auto expectArea = [&](const cv::Rect& area, const cv::Rect& visible) {
    expectSame(extractor->extract(image, 1, {area, {}}),
               moved(extractor->extract(image(visible)), visible.tl(), image.size()));
  };
  expectArea({-50, -60, 250, 260}, {0, 0, 200, 200});
  expectArea({250, 150, 500, 151}, {250, 150, 150, 150});
  const int most = std::numeric_limits<int>::max();
  expectArea({200, 100, most, most}, {200, 100, 200, 200});
  expectArea({-100, -100, most, 300}, {0, 0, 400, 200});
}

TEST_P(Region, TinyAreasDoNoHarm) {
  const cv::Mat image = shapes();
  const auto extractor = create();
  for (const cv::Rect& area : {cv::Rect(0, 0, 1, 1),
                               {399, 299, 1, 1},
                               {200, 100, 1, 150},
                               {100, 200, 250, 1},
                               {-5, -5, 6, 6},
                               {50, 50, 7, 9},
                               {398, 0, 100, 300}}) {
    const Features features = extractor->extract(image, 1, {area, {}});
    EXPECT_TRUE(features.keypoints.empty()) << area;
    EXPECT_TRUE(features.descriptors.empty()) << area;
    EXPECT_EQ(features.image_size, image.size());
  }
  for (int side = 10; side < 90; side += 7) {
    const Features features = extractor->extract(image, 1, {{150, 120, side, 100 - side}, {}});
    EXPECT_EQ(features.descriptors.rows, int(features.keypoints.size())) << side;
  }
}

TEST_P(Region, AMaskDropsJustWhatLiesOnZeros) {
  const cv::Mat image = shapes(1, {500, 400}), mask = holes(image.size());
  const auto extractor = create();
  const Features all = extractor->extract(image), expected = masked(all, mask);
  ASSERT_LT(expected.keypoints.size() + 20, all.keypoints.size());
  ASSERT_GT(expected.keypoints.size(), 50u);
  expectSame(extractor->extract(image, 2, {{}, mask}), expected);
  cv::Mat few = mask / 255;
  few.row(3).setTo(77);
  const Features any_value = extractor->extract(image, 1, {{}, few});
  expectSame(any_value, masked(all, few));
}

TEST_P(Region, AMaskInsideAnArea) {
  // The mask has the size of the whole image; it may be a part of a larger matrix.
  const cv::Mat image = shapes(1, {500, 400}), large = holes({700, 600}, 2);
  const cv::Mat mask = large(cv::Rect(60, 70, 500, 400));
  large.rowRange(250, 310).setTo(0);
  const cv::Rect area(111, 33, 300, 250);
  const auto extractor = create();
  const Features all = extractor->extract(image, 1, {area, {}}), expected = masked(all, mask);
  ASSERT_LT(expected.keypoints.size(), all.keypoints.size());
  ASSERT_GT(expected.keypoints.size(), 20u);
  expectSame(extractor->extract(image, 1, {area, mask}), expected);
  // Zeros outside the area do not count.
  cv::Mat outside = cv::Mat::zeros(image.size(), CV_8U);
  outside(area).setTo(1);
  expectSame(extractor->extract(image, 1, {area, outside}), all);
}

TEST_P(Region, NothingIsLeftOfAMaskOfZeros) {
  const cv::Mat image = shapes(), zeros = cv::Mat::zeros(image.size(), CV_8U);
  for (const OptionMap& options : {OptionMap{}, {{"max_features", "30"}}}) {
    const Features features = create(options)->extract(image, 2, {{}, zeros});
    EXPECT_TRUE(features.keypoints.empty());
    EXPECT_TRUE(features.frames.empty());
    EXPECT_TRUE(features.descriptors.empty());
    EXPECT_EQ(features.image_size, image.size());
  }
  // Nor where nothing was to be found.
  const cv::Mat blank(200, 200, CV_8U, cv::Scalar(9)), tiny(5, 5, CV_8U, cv::Scalar(9));
  for (const cv::Mat& empty : {blank, tiny}) {
    cv::Mat mask = cv::Mat::ones(empty.size(), CV_8U);
    mask.col(2).setTo(0);
    EXPECT_TRUE(create()->extract(empty, 1, {{}, mask}).keypoints.empty());
  }
}

TEST_P(Region, TheCapCountsWhatIsNotMasked) {
  // The strongest are on the left, which is masked.
  cv::Mat image = shapes(1, {800, 300});
  cv::Mat weak = image.colRange(400, 800);
  weak.convertTo(weak, -1, 0.5, 128 * 0.5);
  cv::Mat mask(image.size(), CV_8U, cv::Scalar(255));
  mask.colRange(0, 400).setTo(0);
  for (const char* spread : {"false", "true"}) {
    const Features features =
        create({{"max_features", "60"}, {"spread", spread}})->extract(image, 1, {{}, mask});
    EXPECT_LE(features.keypoints.size(), 60u);
    EXPECT_GE(features.keypoints.size(), onePass() ? 54u : 30u) << spread;
    for (const cv::KeyPoint& k : features.keypoints) EXPECT_GE(k.pt.x, 399.5F);
  }
  // These divide their cap among the levels of the pyramid.
  if (detector() == "orb" || detector() == "cv_orb") return;
  Features strongest = create()->extract(image, 1, {{}, mask});
  const Features capped = create({{"max_features", "60"}})->extract(image, 1, {{}, mask});
  for (std::size_t i = 0; i < capped.keypoints.size(); ++i) {
    ASSERT_GE(capped.keypoints[i].response,
              strongest.keypoints[std::min<std::size_t>(59, strongest.keypoints.size() - 1)].response);
    if (onePass()) {
      ASSERT_EQ(capped.keypoints[i].pt, strongest.keypoints[i].pt);
    }
  }
}

TEST_P(Region, ReducedAreasGiveExactPlaces) {
  // max_megapixels is that of the area. Masked is what lies on a zero of the mask as it was given.
  const cv::Mat small = shapes(1, {400, 300});
  cv::Mat large;
  cv::resize(small, large, {}, 4, 4, cv::INTER_NEAREST);
  const cv::Rect area(400, 240, 1000, 800);
  const OptionMap options = {{"max_features", "0"}, {"max_megapixels", "0.05"}};
  const Features all = create(options)->extract(large, 1, {area, {}});
  ASSERT_GT(all.keypoints.size(), 30u);
  expectSame(all, moved(create(options)->extract(large(area)), area.tl(), large.size()));
  const Features reduced = create()->extract(small(cv::Rect(100, 60, 250, 200)));
  ASSERT_EQ(all.keypoints.size(), reduced.keypoints.size());
  for (std::size_t i = 0; i < all.keypoints.size(); ++i) {
    ASSERT_NEAR(all.keypoints[i].pt.x, (reduced.keypoints[i].pt.x + 100.5) * 4 - 0.5, 1e-2);
    ASSERT_NEAR(all.keypoints[i].pt.y, (reduced.keypoints[i].pt.y + 60.5) * 4 - 0.5, 1e-2);
  }
  const cv::Mat mask = holes(large.size(), 3);
  const Features expected = masked(all, mask);
  ASSERT_LT(expected.keypoints.size(), all.keypoints.size());
  expectSame(create(options)->extract(large, 1, {area, mask}), expected);
  // A small area of a large image is not reduced.
  const cv::Rect corner(800, 600, 250, 200);
  expectSame(create(options)->extract(large, 1, {corner, {}}), create()->extract(large, 1, {corner, {}}));
}

TEST_P(Region, EachImageOfAPairHasItsOwn) {
  const cv::Mat left = shapes(1, {500, 400}, 2), right = shapes(3, {400, 300}, 3);
  const FeatureRegion left_region{{0, 0, 250, 400}, holes(left.size())};
  const FeatureRegion right_region{{150, 0, 250, 300}, {}};
  const auto extractor = create();
  const Features expected_left = extractor->extract(left, 1, left_region);
  const Features expected_right = extractor->extract(right, 1, right_region);
  for (const int threads : {0, 1, 2, 3}) {
    const auto [a, b] = extractPair(*extractor, left, right, threads, left_region, right_region);
    expectSame(a, expected_left);
    expectSame(b, expected_right);
    const auto [c, d] = extractPair(*extractor, left, right, threads, {}, right_region);
    EXPECT_GT(c.keypoints.size(), a.keypoints.size());
    expectSame(d, expected_right);
    // A mask for the other image is refused, on either thread.
    EXPECT_TRUE(mentions(errorOf<std::invalid_argument>(
                             [&] { extractPair(*extractor, left, right, threads, {}, left_region); }),
                         {"needed", "image", "mask"}));
  }
}

INSTANTIATE_TEST_SUITE_P(All, Region, ::testing::ValuesIn(combinations()), combinationName);

TEST(FeatureRegions, RefusalsSayWhatTheyGot) {
  const auto extractor = createExtractor("orb+orb");
  const cv::Mat image = shapes();
  const auto refusal = [&](const FeatureRegion& region) {
    return errorOf<std::invalid_argument>([&] { extractor->extract(image, 1, region); });
  };
  const auto outside = [&](const cv::Rect& area) { return refusal({area, {}}); };
  EXPECT_EQ(outside({400, 0, 10, 10}),
            "the area of 10x10 px at (400, 0) lies outside the image of 400x300 px");
  EXPECT_TRUE(contains(outside({0, 300, 10, 10}), "at (0, 300) lies outside"));
  EXPECT_TRUE(contains(outside({-10, 0, 10, 10}), "at (-10, 0) lies outside"));
  EXPECT_TRUE(contains(outside({5, -20, 100, 20}), "at (5, -20) lies outside"));
  const int most = std::numeric_limits<int>::max(), least = std::numeric_limits<int>::min();
  EXPECT_TRUE(contains(outside({most, most, most, most}), "lies outside"));
  EXPECT_TRUE(contains(outside({least, 0, most, 10}), "lies outside"));
  const auto refusedMask = [&](const cv::Mat& mask) { return refusal({{}, mask}); };
  EXPECT_EQ(refusedMask(cv::Mat::ones(300, 399, CV_8U)),
            "mask has 399x300 px; needed: 400x300 px, the size of the image");
  EXPECT_EQ(refusedMask(cv::Mat::ones(300, 400, CV_8UC3)),
            "mask has type CV_8UC3; needed: 8 bits with 1 channel");
  EXPECT_EQ(refusedMask(cv::Mat::ones(300, 400, CV_32F)),
            "mask has type CV_32FC1; needed: 8 bits with 1 channel");
  // A mask of the area instead of the image, too.
  EXPECT_TRUE(
      mentions(refusal({{10, 10, 100, 50}, cv::Mat::ones(50, 100, CV_8U)}), {"needed", "image", "mask"}));
  // The image is checked first.
  EXPECT_TRUE(mentions(errorOf([&] {
                         extractor->extract({}, 1, {{1000, 0, 5, 5}, {}});
                       }),
                       {"image", "empty"}));
}

TEST(FeatureRegions, OrbCapsItsLevelsWithAMaskAsWithout) {
  // One masked pixel makes little difference.
  const cv::Mat image = shapes(1, {800, 600});
  cv::Mat mask = cv::Mat::ones(image.size(), CV_8U);
  mask.at<std::uint8_t>(0, 0) = 0;
  for (const char* name : {"orb+orb", "orb+sift"}) {
    for (const char* levels : {"1", "3", "8"}) {
      const auto extractor = createExtractor(name, {{"orb", {{"max_features", "300"}, {"levels", levels}}}});
      const Features plain = extractor->extract(image);
      const Features with_mask = extractor->extract(image, 1, {{}, mask});
      std::map<int, int> plain_levels, mask_levels;
      std::size_t common = 0;
      for (const cv::KeyPoint& k : plain.keypoints) {
        ++plain_levels[k.octave];
        common += std::any_of(
            with_mask.keypoints.begin(), with_mask.keypoints.end(),
            [&k](const cv::KeyPoint& other) { return other.pt == k.pt && other.octave == k.octave; });
      }
      for (const cv::KeyPoint& k : with_mask.keypoints) ++mask_levels[k.octave];
      for (const auto& [level, count] : plain_levels) {
        EXPECT_NEAR(mask_levels[level], count, 2) << name << " level " << level << " of " << levels;
      }
      EXPECT_GT(double(common), 0.8 * double(plain.keypoints.size())) << name << " " << levels;
    }
  }
}

}  // namespace
}  // namespace corrsel::core
