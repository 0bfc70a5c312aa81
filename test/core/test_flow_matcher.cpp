#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/tracking/flow_matcher.h"
#include "test_support.h"
#include "tracking/flow_points.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr int kWidth = 320, kHeight = 240;

/// Blocks and discs with soft edges, from -width/2 to 3/2 width and the same in height.
cv::Mat texture(std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat image(2 * kHeight, 2 * kWidth, CV_8UC1, cv::Scalar(128));
  for (int i = 0; i < 1800; ++i) {
    const auto x = static_cast<int>(random.index(2 * kWidth));
    const auto y = static_cast<int>(random.index(2 * kHeight));
    const auto size = 4 + static_cast<int>(random.index(20));
    const cv::Scalar grey(20 + random.index(216));
    if (i % 2 == 0) {
      cv::rectangle(image, cv::Rect(x, y, size, size), grey, cv::FILLED);
    } else {
      cv::circle(image, {x, y}, size / 2, grey, cv::FILLED);
    }
  }
  cv::GaussianBlur(image, image, {}, 1.0);
  return image;
}

/// A plane in front of a camera. The motion maps pixels of the image at the beginning to those of the view.
cv::Mat view(const cv::Mat& scene, const cv::Matx33d& motion) {
  const cv::Matx33d shift(1, 0, -kWidth / 2.0, 0, 1, -kHeight / 2.0, 0, 0, 1);
  cv::Mat image;
  cv::warpPerspective(scene, image, motion * shift, {kWidth, kHeight}, cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return image;
}

cv::Matx33d translation(double x, double y) { return {1, 0, x, 0, 1, y, 0, 0, 1}; }

/// About the centre of the image.
cv::Matx33d similarity(double scale, double degrees) {
  const double c = scale * std::cos(degrees * CV_PI / 180), s = scale * std::sin(degrees * CV_PI / 180);
  return translation(kWidth / 2.0, kHeight / 2.0) * cv::Matx33d(c, -s, 0, s, c, 0, 0, 0, 1) *
         translation(-kWidth / 2.0, -kHeight / 2.0);
}

/// With white noise.
cv::Mat withNoise(const cv::Mat& image, double deviation, Random& random) {
  cv::Mat result = image.clone();
  for (int y = 0; y < result.rows; ++y) {
    for (int x = 0; x < result.cols; ++x) {
      auto& pixel = result.at<std::uint8_t>(y, x);
      pixel = cv::saturate_cast<std::uint8_t>(pixel + deviation * random.normal());
    }
  }
  return result;
}

/// The points of a sequence, with where each of them was seen first.
class Truth {
 public:
  /// @return the distances of the points from where the motion has brought them, px
  std::vector<double> errors(const Features& features, const cv::Matx33d& motion) {
    std::vector<double> result;
    for (const cv::KeyPoint& keypoint : features.keypoints) {
      const auto [found, is_new] =
          begins_.emplace(keypoint.class_id, projected(motion.inv(), keypoint.pt.x, keypoint.pt.y));
      if (is_new) continue;
      const cv::Point2d expected = projected(motion, found->second.x, found->second.y);
      result.push_back(std::hypot(expected.x - keypoint.pt.x, expected.y - keypoint.pt.y));
    }
    return result;
  }

  std::size_t seen() const { return begins_.size(); }

 private:
  std::map<int, cv::Point2d> begins_;
};

std::set<int> numbers(const Features& features) {
  std::set<int> result;
  for (const cv::KeyPoint& keypoint : features.keypoints) result.insert(keypoint.class_id);
  return result;
}

std::size_t common(const std::set<int>& a, const std::set<int>& b) {
  return static_cast<std::size_t>(
      std::count_if(a.begin(), a.end(), [&b](int number) { return b.count(number) != 0; }));
}

FlowOptions fewPoints() {
  FlowOptions options;
  options.max_points = 200;
  return options;
}

/// @param motion  from the image before to the newest one
std::vector<double> stepErrors(const Features& newest, const Features& before, const cv::Matx33d& motion) {
  const Correspondences matches = matchFlow(newest, before);
  std::vector<double> result;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const cv::Point2d expected = projected(motion, matches.right_x[i], matches.right_y[i]);
    result.push_back(std::hypot(expected.x - matches.left_x[i], expected.y - matches.left_y[i]));
  }
  return result;
}

struct Followed {
  std::vector<double> last;  ///< errors in the last image, px
  std::vector<double> step;  ///< errors of the last step, px
  double kept = 0;           ///< of the points of the first image, in the last one
};

Followed follow(const std::vector<cv::Matx33d>& motions, const FlowOptions& options = fewPoints()) {
  const cv::Mat scene = texture();
  FlowMatcher matcher(options);
  Truth truth;
  Followed result;
  std::set<int> first;
  Features before;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    const cv::Matx33d& motion = motions[i];
    const Features features = matcher.track(view(scene, motion));
    result.step =
        i == 0 ? std::vector<double>() : stepErrors(features, before, motion * motions[i - 1].inv());
    before = features;
    result.last = truth.errors(features, motion);
    if (first.empty()) first = numbers(features);
    result.kept = static_cast<double>(common(first, numbers(features))) / static_cast<double>(first.size());
  }
  return result;
}

std::vector<cv::Matx33d> steps(int n, const std::function<cv::Matx33d(int)>& motion) {
  std::vector<cv::Matx33d> result;
  for (int i = 0; i < n; ++i) result.push_back(motion(i));
  return result;
}

TEST(FlowMatcher, FollowsTranslation) {
  const Followed slow = follow(steps(40, [](int i) { return translation(0.7 * i, -0.4 * i); }));
  EXPECT_GT(slow.last.size(), 150u);
  EXPECT_LT(quantile(slow.last, 0.95), 0.1);
  EXPECT_GT(slow.kept, 0.8);
  // It starts at once, and is more than a window from image to image.
  const Followed fast = follow(steps(6, [](int i) { return translation(19.0 * i, 9.0 * i); }));
  EXPECT_GT(fast.last.size(), 80u);
  EXPECT_LT(quantile(fast.last, 0.9), 0.3);
}

TEST(FlowMatcher, FollowsRotationAndZoom) {
  // What turns or grows shifts the place that a patch stands for within the patch, but hardly in one step.
  for (const bool turns : {true, false}) {
    const Followed followed = follow(steps(
        40, [turns](int i) { return turns ? similarity(1, 1.5 * i) : similarity(std::pow(1.015, i), 0); }));
    EXPECT_GT(followed.last.size(), 120u);
    EXPECT_LT(quantile(followed.step, 0.9), 0.4);
    EXPECT_LT(quantile(followed.step, 0.5), 0.15);
    EXPECT_LT(quantile(followed.last, 0.5), 4);
    EXPECT_LT(quantile(followed.last, 0.9), 8);
    EXPECT_GT(followed.kept, 0.2);
  }
}

TEST(FlowMatcher, DoesNotDriftAtRest) {
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  for (const double noise : {2.0, 5.0}) {
    Random random(5);
    FlowMatcher matcher(fewPoints());
    Truth truth;
    std::set<int> first, last;
    std::vector<double> errors;
    for (int i = 0; i < 300; ++i) {  // 10 s at 30 Hz
      const Features features = matcher.track(withNoise(image, noise, random));
      errors = truth.errors(features, cv::Matx33d::eye());
      last = numbers(features);
      if (i == 1) first = last;  // in the second image, the noise is known
      if (i == 0) continue;
      EXPECT_LT(quantile(errors, 0.99), 0.3) << "noise " << noise << ", image " << i;
    }
    EXPECT_GT(first.size(), 130u);
    EXPECT_GT(common(first, last), 0.9 * static_cast<double>(first.size())) << noise;
    EXPECT_LT(quantile(errors, 0.5), 0.06) << noise;
  }
}

/// How far the points are from the affine map that fits best to their motion, px. The whole image may have
/// moved; what remains is not the motion of a camera that hardly turns.
std::vector<double> deviations(const Correspondences& matches) {
  const int n = static_cast<int>(matches.size());
  cv::Mat from(n, 3, CV_64F), to(n, 2, CV_64F), map;
  for (int i = 0; i < n; ++i) {
    const auto row = static_cast<std::size_t>(i);
    cv::Mat(cv::Matx13d(matches.right_x[row], matches.right_y[row], 1)).copyTo(from.row(i));
    cv::Mat(cv::Matx12d(matches.left_x[row], matches.left_y[row])).copyTo(to.row(i));
  }
  cv::solve(from, to, map, cv::DECOMP_SVD);
  const cv::Mat off = from * map - to;
  std::vector<double> result;
  for (int i = 0; i < n; ++i) result.push_back(cv::norm(off.row(i)));
  return result;
}

TEST(FlowMatcher, DoesNotDriftInFrontOfARealCameraAtRest) {
  const std::string folder = sharedData("euroc_rest");
  if (folder.empty()) GTEST_SKIP() << "no euroc_rest";
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder + "/cam0/data")) {
    files.push_back(entry.path().string());
  }
  std::sort(files.begin(), files.end());
  ASSERT_EQ(files.size(), 40u);
  FlowMatcher matcher;
  Features first;
  for (const std::string& file : files) {
    const Features features = matcher.track(cv::imread(file, cv::IMREAD_GRAYSCALE));
    if (first.keypoints.empty()) first = features;
    const Correspondences matches = matchFlow(features, first);
    ASSERT_GT(matches.size(), 0.95 * static_cast<double>(first.keypoints.size())) << file;
    EXPECT_LT(quantile(deviations(matches), 0.5), 0.1) << file;
    EXPECT_LT(quantile(deviations(matches), 0.95), 0.3) << file;
  }
}

TEST(FlowMatcher, DoesNotDriftInSlowMotion) {
  const auto sway = [](int i) { return translation(6 * std::sin(0.05 * i), 4 * std::sin(0.03 * i)); };
  const Followed swaying = follow(steps(200, sway));
  EXPECT_GT(swaying.kept, 0.8);
  EXPECT_LT(quantile(swaying.last, 0.99), 0.15);
}

TEST(FlowMatcher, EnduresChangesOfTheLight) {
  const cv::Mat scene = view(texture(), cv::Matx33d::eye());
  FlowMatcher matcher(fewPoints());
  Truth truth;
  std::vector<double> errors;
  std::set<int> first, last;
  for (int i = 0; i < 60; ++i) {
    cv::Mat image;
    scene.convertTo(image, CV_8U, 1 - 0.008 * i, 0.5 * i);
    const Features features = matcher.track(image);
    errors = truth.errors(features, cv::Matx33d::eye());
    last = numbers(features);
    if (i == 0) first = last;
  }
  EXPECT_GT(common(first, last), 0.8 * static_cast<double>(first.size()));
  EXPECT_LT(quantile(errors, 0.9), 0.5);
}

TEST(FlowMatcher, LosesWhatIsCovered) {
  const cv::Mat scene = view(texture(), cv::Matx33d::eye());
  const cv::Mat board = view(texture(9), cv::Matx33d::eye());
  FlowMatcher matcher(fewPoints());
  const std::set<int> first = numbers(matcher.track(scene));
  Features features;
  const int end = 160;
  for (int edge = 0; edge <= end; edge += 8) {  // the board comes from the left
    cv::Mat image = scene.clone();
    if (edge > 0)
      board(cv::Rect(kWidth - edge, 0, edge, kHeight)).copyTo(image(cv::Rect(0, 0, edge, kHeight)));
    features = matcher.track(image);
  }
  std::size_t old = 0, new_ones = 0;
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    if (keypoint.pt.x > end - 8) continue;
    (first.count(keypoint.class_id) != 0 ? old : new_ones) += 1;
  }
  EXPECT_LT(old, first.size() / 50);
  EXPECT_GT(new_ones, 20u);
}

TEST(FlowMatcher, FindsPointsWhereTheImageIsEmpty) {
  const cv::Mat scene = texture();
  FlowMatcher matcher(fewPoints());
  const std::set<int> first = numbers(matcher.track(view(scene, cv::Matx33d::eye())));
  ASSERT_EQ(first.size(), 200u);
  Features features;
  for (int i = 1; i <= 20; ++i) features = matcher.track(view(scene, translation(-6.0 * i, 0)));
  std::size_t entered = 0;
  for (const cv::KeyPoint& keypoint : features.keypoints) entered += keypoint.pt.x > kWidth - 100 ? 1 : 0;
  EXPECT_GT(entered, 15u);
  EXPECT_GT(features.keypoints.size(), 155u);
  EXPECT_LE(features.keypoints.size(), 200u);
  // Those who left were replaced, and their numbers are not used again.
  EXPECT_LT(common(first, numbers(features)), 150u);
  EXPECT_GT(*numbers(features).rbegin(), 200);
}

TEST(FlowMatcher, DetectsOnlyWhereTooFewPointsAreLeft) {
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  FlowOptions options = fewPoints();
  options.refill = 0;
  FlowMatcher never(options);
  EXPECT_TRUE(never.track(image).keypoints.empty());
  options.refill = 0.5;
  FlowMatcher half(options);
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255));
  ASSERT_EQ(half.track(image).keypoints.size(), 200u);
  mask.colRange(0, 100).setTo(0);
  const std::size_t left = half.track(image, 1, {{}, mask}).keypoints.size();
  ASSERT_GT(left, 100u);
  EXPECT_EQ(half.track(image).keypoints.size(), left);
  mask.colRange(0, 300).setTo(0);
  half.track(image, 1, {{}, mask});
  for (int i = 0; i < 5; ++i) half.track(image);
  EXPECT_EQ(half.track(image).keypoints.size(), 200u);
}

TEST(FlowMatcher, KeepsPointsApartAndOlderOnesWin) {
  FlowOptions options = fewPoints();
  options.min_distance = 12;
  FlowMatcher matcher(options);
  const cv::Mat scene = texture();
  for (int i = 0; i < 30; ++i) {  // points come closer to each other
    const Features features = matcher.track(view(scene, similarity(std::pow(0.98, i), 0)));
    for (std::size_t a = 0; a < features.keypoints.size(); ++a) {
      for (std::size_t b = a + 1; b < features.keypoints.size(); ++b) {
        ASSERT_GE(cv::norm(features.keypoints[a].pt - features.keypoints[b].pt), 12.0 - 1e-4);
        ASSERT_LT(features.keypoints[a].class_id, features.keypoints[b].class_id);
      }
    }
  }
}

TEST(FlowMatcher, PointsStayWhereTheRegionAllowsThem) {
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  FlowMatcher matcher(fewPoints());
  ASSERT_FALSE(matcher.track(image).keypoints.empty());
  FeatureRegion region{{40, 20, 200, 180}, cv::Mat(image.size(), CV_8UC1, cv::Scalar(255))};
  region.mask(cv::Rect(100, 0, 60, kHeight)).setTo(0);
  for (int i = 0; i < 7; ++i) {
    const Features features = matcher.track(image, 1, region);
    EXPECT_GT(features.keypoints.size(), 50u);
    for (const cv::KeyPoint& keypoint : features.keypoints) {
      const cv::Point pixel(cvRound(keypoint.pt.x), cvRound(keypoint.pt.y));
      EXPECT_TRUE(region.area.contains(pixel)) << pixel;
      EXPECT_NE(region.mask.at<std::uint8_t>(pixel), 0) << pixel;
    }
  }
}

TEST(FlowMatcher, LeavesTheImageInOrder) {
  const cv::Mat scene = texture();
  FlowMatcher matcher(fewPoints());
  for (int i = 0; i < 20; ++i) {
    const Features features = matcher.track(view(scene, translation(7.0 * i, 5.0 * i)));
    for (const cv::KeyPoint& keypoint : features.keypoints) {
      ASSERT_TRUE(cv::Rect(8, 8, kWidth - 16, kHeight - 16).contains(keypoint.pt)) << keypoint.pt;
    }
  }
}

TEST(FlowMatcher, GivesTheSameWithAnyNumberOfThreads) {
  const cv::Mat scene = texture();
  const auto run = [&scene](int threads) {
    FlowMatcher matcher(fewPoints());
    std::vector<Features> result;
    Random random(3);
    for (int i = 0; i < 12; ++i) {
      const cv::Mat image = withNoise(view(scene, similarity(std::pow(1.01, i), i)), 3, random);
      result.push_back(matcher.track(image, threads));
    }
    return result;
  };
  const int before = cv::getNumThreads();
  const std::vector<Features> expected = run(1);
  for (const int opencv_threads : {1, 2, 3}) {
    cv::setNumThreads(opencv_threads);
    const std::vector<Features> actual = run(opencv_threads);
    for (std::size_t i = 0; i < expected.size(); ++i) {
      ASSERT_EQ(actual[i].keypoints.size(), expected[i].keypoints.size()) << i;
      for (std::size_t k = 0; k < expected[i].keypoints.size(); ++k) {
        EXPECT_EQ(actual[i].keypoints[k].pt, expected[i].keypoints[k].pt);
        EXPECT_EQ(actual[i].keypoints[k].class_id, expected[i].keypoints[k].class_id);
      }
    }
  }
  cv::setNumThreads(before);
}

TEST(FlowMatcher, BeginsAnewWithAnotherSizeAndAfterAReset) {
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  FlowMatcher matcher(fewPoints());
  const std::set<int> first = numbers(matcher.track(image));
  EXPECT_EQ(common(first, numbers(matcher.track(image))), first.size());
  cv::Mat smaller;
  cv::resize(image, smaller, {}, 0.75, 0.75);
  const Features other = matcher.track(smaller);
  EXPECT_EQ(other.image_size, smaller.size());
  EXPECT_GT(other.keypoints.size(), 50u);
  EXPECT_EQ(common(first, numbers(other)), 0u);
  matcher.track(image);
  matcher.reset();
  EXPECT_EQ(common(first, numbers(matcher.track(image))), 0u);
}

TEST(FlowMatcher, BlankAndTinyImagesHaveNoPoints) {
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  for (const cv::Size& size : {cv::Size(kWidth, kHeight), {1, 1}, {3, 200}, {17, 17}, {200, 5}, {33, 40}}) {
    FlowMatcher matcher(fewPoints());
    for (int i = 0; i < 3; ++i) {
      EXPECT_TRUE(matcher.track(cv::Mat(size, CV_8UC1, cv::Scalar(80))).keypoints.empty()) << size;
    }
    matcher.track(image(cv::Rect({0, 0}, size)));
    EXPECT_NO_THROW(matcher.track(image(cv::Rect({0, 0}, size)))) << size;
  }
  FlowMatcher matcher(fewPoints());
  ASSERT_FALSE(matcher.track(image).keypoints.empty());
  EXPECT_TRUE(matcher.track(cv::Mat(image.size(), CV_8UC1, cv::Scalar(0))).keypoints.empty());
  EXPECT_EQ(matcher.track(image).keypoints.size(), 200u);
}

TEST(FlowMatcher, TakesImagesOfSixteenBitsAndColour) {
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  cv::Mat deep, colour;
  image.convertTo(deep, CV_16U, 257);
  cv::cvtColor(image, colour, cv::COLOR_GRAY2BGR);
  FlowMatcher matcher(fewPoints());
  const Features expected = matcher.track(image);
  for (const cv::Mat& other : {deep, colour}) {
    const Features features = matcher.track(other);
    ASSERT_EQ(features.keypoints.size(), expected.keypoints.size());
    EXPECT_EQ(features.keypoints.back().class_id, expected.keypoints.back().class_id);
  }
}

TEST(FlowMatcher, AnyDetectorOfTheCatalogueFindsPoints) {
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  std::vector<std::string> missing;
  for (const auto& algorithm : missingAlgorithms()) missing.push_back(algorithm.first);
  for (const std::string& detector : detectorNames()) {
    if (std::count(missing.begin(), missing.end(), detector) != 0) continue;
    FlowOptions options = fewPoints();
    options.detector = detector;
    FlowMatcher matcher(options, {{detector, {{"max_features", "3"}}}});  // has no effect
    EXPECT_EQ(matcher.name(), detector + "+flow");
    EXPECT_GT(matcher.track(image).keypoints.size(), 20u) << detector;
  }
}

TEST(FlowMatcher, WhatCannotBeUsedIsNamed) {
  const auto refusal = [](const FlowOptions& options, const AlgorithmOptions& own = {}) {
    return errorOf<std::invalid_argument>([&] { FlowMatcher(options, own); });
  };
  FlowOptions options;
  options.window = 3;
  EXPECT_TRUE(mentions(refusal(options), {"window", "3", "5"}));
  options = {};
  options.detector = "orbb";
  EXPECT_TRUE(mentions(refusal(options), {"orbb", "orb"}));
  EXPECT_TRUE(mentions(refusal({}, {{"orb", {{"levels", "99"}}}}), {"orb", "levels", "99"}));
  FlowMatcher matcher(fewPoints());
  const cv::Mat image = view(texture(), cv::Matx33d::eye());
  const Features before = matcher.track(image);
  EXPECT_TRUE(mentions(errorOf([&] { matcher.track({}); }), {"image", "empty"}));
  EXPECT_TRUE(mentions(errorOf([&] {
                         matcher.track(image, 1, {{}, cv::Mat(9, 9, CV_8UC1)});
                       }),
                       {"mask", "9x9", "320x240"}));
  EXPECT_TRUE(mentions(errorOf([&] { matcher.track(image, 1, {{900, 0, 10, 10}, {}}); }), {"900"}));
  EXPECT_EQ(numbers(matcher.track(image)), numbers(before)) << "nothing was changed";
}

TEST(FlowMatcher, TheSameNumbersAreMatched) {
  const cv::Mat scene = texture();
  FlowMatcher matcher(fewPoints());
  const Features first = matcher.track(view(scene, cv::Matx33d::eye()));
  Features last;
  for (int i = 1; i <= 10; ++i) last = matcher.track(view(scene, translation(-5.0 * i, 0)));
  const Correspondences matches = matchFlow(last, first);
  EXPECT_EQ(matches.inconsistency(), "");
  EXPECT_TRUE(matches.distance.empty());
  EXPECT_EQ(matches.left_size, cv::Size(kWidth, kHeight));
  EXPECT_EQ(matches.size(), common(numbers(last), numbers(first)));
  ASSERT_GT(matches.size(), 80u);
  ASSERT_LT(matches.size(), 200u);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const cv::KeyPoint &left = last.keypoints[matches.left_index[i]],
                       &right = first.keypoints[matches.right_index[i]];
    EXPECT_EQ(left.class_id, right.class_id);
    EXPECT_EQ(left.pt, cv::Point2f(matches.left_x[i], matches.left_y[i]));
    EXPECT_EQ(right.pt, cv::Point2f(matches.right_x[i], matches.right_y[i]));
  }
  EXPECT_TRUE(matchFlow(last, {}).empty());
}

TEST(FlowPoints, EarlierPointsKeepTheirDistance) {
  const std::vector<cv::Point2f> points = {{10, 10}, {14, 10}, {18, 10}, {10, 18}, {300, 200}, {299, 199}};
  EXPECT_EQ(keepDistant(points, {320, 240}, 8), (std::vector<char>{1, 0, 1, 1, 1, 0}));
  EXPECT_EQ(keepDistant(points, {320, 240}, 0), std::vector<char>(6, 1));
}

TEST(FlowPoints, EmptyCellsAreFilledFirst) {
  // Cells of about 50 px; two points and three strong candidates are in the first one.
  const std::vector<cv::Point2f> points = {{5, 5}, {30, 30}};
  const std::vector<cv::Point2f> candidates = {{10, 30}, {30, 10}, {20, 20}, {90, 10}, {92, 30}, {10, 90}};
  EXPECT_EQ(chooseNew(candidates, points, {100, 100}, 5), (std::vector<std::size_t>{3, 5, 4}));
  EXPECT_EQ(chooseNew(candidates, points, {100, 100}, 2), std::vector<std::size_t>());
  EXPECT_EQ(chooseNew(candidates, points, {100, 100}, 100).size(), 6u);
}

}  // namespace
}  // namespace corrsel::core
