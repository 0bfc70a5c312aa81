#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/matching/sequence.h"
#include "feature_checks.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr int kSide = 8, kPerCell = 20;

/// The same number of features in each of the first `cells` of an 8 x 8 grid, numbered cell by cell.
std::shared_ptr<Features> gridFeatures(int cells = kSide * kSide) {
  auto features = std::make_shared<Features>();
  features->image_size = {800, 400};
  for (int i = 0; i < cells * kPerCell; ++i) {
    const int cell = i / kPerCell;
    features->keypoints.emplace_back(100.0F * float(cell % kSide) + 50, 50.0F * float(cell / kSide) + 25,
                                     4.0F);
  }
  return features;
}

/// Matches that end at `each` features of every one of the given cells, with a ratio of distances.
Correspondences gridMatches(const std::vector<int>& cells, int each = kPerCell, float ratio = 0.5F) {
  Correspondences matches;
  for (const int cell : cells) {
    for (int i = 0; i < each; ++i) {
      matches.add({0, 0}, {0, 0});
      matches.left_index.push_back(std::uint32_t(matches.left_index.size()));
      matches.right_index.push_back(std::uint32_t(cell * kPerCell + i));
      matches.distance.push_back(ratio * 100);
      matches.second_distance.push_back(100);
    }
  }
  return matches;
}

std::vector<int> firstCells(int n) {
  std::vector<int> cells(std::size_t(n), 0);
  std::iota(cells.begin(), cells.end(), 0);
  return cells;
}

SequenceOptions keyframes(double min_overlap = 0.5) {
  SequenceOptions options;
  options.reference = SequenceOptions::Reference::kKeyframe;
  options.min_overlap = min_overlap;
  return options;
}

SequenceOptions previous(int step) {
  SequenceOptions options;
  options.step = step;
  return options;
}

/// The id of the reference; -1 where there is none.
int referenceId(const Sequence& sequence) {
  return sequence.reference() ? int(sequence.reference()->id) : -1;
}

TEST(Overlap, IsTheShareOfTheCellsThatAreSeen) {
  const auto features = gridFeatures();
  EXPECT_EQ(overlap(gridMatches(firstCells(64)), *features, 0.8), 1);
  EXPECT_EQ(overlap(gridMatches(firstCells(32)), *features, 0.8), 0.5);
  EXPECT_EQ(overlap(gridMatches({0}), *features, 0.8), 1 / 64.0);
  EXPECT_EQ(overlap({}, *features, 0.8), 0);
  // Cells without features do not count.
  EXPECT_EQ(overlap(gridMatches(firstCells(8)), *gridFeatures(10), 0.8), 0.8);
}

TEST(Overlap, TakesFifteenPercentOfACell) {
  const auto features = gridFeatures();
  EXPECT_EQ(overlap(gridMatches(firstCells(64), 2), *features, 0.8), 0);
  EXPECT_EQ(overlap(gridMatches(firstCells(64), 3), *features, 0.8), 1);
  // One feature that is found again and again is one.
  Correspondences matches = gridMatches(firstCells(64), 5);
  for (std::uint32_t& right : matches.right_index) right -= right % kPerCell;
  EXPECT_EQ(overlap(matches, *features, 0.8), 0);
}

TEST(Overlap, CountsWhatPassesTheRatioTest) {
  const auto features = gridFeatures();
  const auto at = [&features](float ratio) {
    return overlap(gridMatches(firstCells(64), 4, ratio), *features, 0.8);
  };
  EXPECT_EQ(at(0.79F), 1);
  EXPECT_EQ(at(0.81F), 0);
  EXPECT_EQ(at(std::numeric_limits<float>::quiet_NaN()), 0);
  Correspondences matches = gridMatches(firstCells(64));
  for (float& second : matches.second_distance) second = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(overlap(matches, *features, 1), 0);
  matches.distance.clear();
  matches.second_distance.clear();
  EXPECT_EQ(overlap(matches, *features, 0.8), 1);
}

TEST(Overlap, IsUndefinedWithoutFeatures) {
  Features none;
  none.image_size = {640, 480};
  EXPECT_TRUE(std::isnan(overlap({}, none, 0.8)));
  EXPECT_TRUE(std::isnan(overlap({}, Features(), 0.8)));
}

TEST(Overlap, RefusesMatchesOfAnotherReference) {
  const auto features = gridFeatures(1);
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { overlap(gridMatches({1}), *features, 0.8); }),
                       {"match 0", "feature 20", "another reference"}));
  Correspondences matches;
  matches.add({1, 2}, {3, 4});
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] { overlap(matches, *features, 0.8); }),
                       {"matches", "feature numbers"}));
}

TEST(SequenceOfFrames, ComparesWithTheFrameStepFramesAgo) {
  for (const int step : {1, 2, 5, 100}) {
    Sequence sequence(previous(step));
    for (int i = 0; i < 2 * step + 3; ++i) {
      EXPECT_EQ(referenceId(sequence), i < step ? -1 : i - step) << step;
      EXPECT_TRUE(std::isnan(sequence.lastOverlap()) == (i <= step));
      sequence.add({std::uint64_t(i), gridFeatures(1)}, {});
    }
  }
}

TEST(SequenceOfFrames, TellsTheOverlapOfTheNewestFrame) {
  for (const SequenceOptions& options : {previous(1), keyframes(0.1)}) {
    Sequence sequence(options);
    EXPECT_TRUE(std::isnan(sequence.lastOverlap()));
    sequence.add({1, gridFeatures()}, {});
    EXPECT_TRUE(std::isnan(sequence.lastOverlap()));
    sequence.add({2, gridFeatures()}, gridMatches(firstCells(16)));
    EXPECT_EQ(sequence.lastOverlap(), 0.25);
    sequence.add({3, gridFeatures()}, gridMatches(firstCells(48)));
    EXPECT_EQ(sequence.lastOverlap(), 0.75);
  }
}

TEST(SequenceOfFrames, RenewsTheKeyframeBelowTheOverlap) {
  Sequence sequence(keyframes(0.5));
  EXPECT_EQ(referenceId(sequence), -1);
  sequence.add({1, gridFeatures()}, {});
  EXPECT_EQ(referenceId(sequence), 1);
  sequence.add({2, gridFeatures()}, gridMatches(firstCells(60)));
  sequence.add({3, gridFeatures()}, gridMatches(firstCells(32)));
  EXPECT_EQ(referenceId(sequence), 1);  // 0.5 is not below
  sequence.add({4, gridFeatures()}, gridMatches(firstCells(31)));
  EXPECT_EQ(referenceId(sequence), 4);
  sequence.add({5, gridFeatures()}, {});
  EXPECT_EQ(referenceId(sequence), 5);
  // The ends of the range: never, and whenever anything is missing.
  sequence.setOptions(keyframes(0));
  sequence.add({6, gridFeatures()}, {});
  EXPECT_EQ(referenceId(sequence), 5);
  sequence.setOptions(keyframes(1));
  sequence.add({7, gridFeatures()}, gridMatches(firstCells(64)));
  EXPECT_EQ(referenceId(sequence), 5);
  sequence.add({8, gridFeatures()}, gridMatches(firstCells(63)));
  EXPECT_EQ(referenceId(sequence), 8);
}

TEST(SequenceOfFrames, AFrameWithoutFeaturesIsNoKeyframe) {
  const auto empty = std::make_shared<Features>();
  Sequence sequence(keyframes());
  sequence.add({1, empty}, {});
  EXPECT_EQ(referenceId(sequence), -1);
  sequence.add({2, gridFeatures()}, {});
  EXPECT_EQ(referenceId(sequence), 2);
  sequence.add({3, empty}, {});  // the light went out
  EXPECT_EQ(sequence.lastOverlap(), 0);
  EXPECT_EQ(referenceId(sequence), 2);
  sequence.add({4, gridFeatures()}, gridMatches(firstCells(60)));
  EXPECT_EQ(referenceId(sequence), 2);

  // As a previous frame it counts like any other.
  Sequence steps(previous(1));
  steps.add({1, empty}, {});
  ASSERT_EQ(referenceId(steps), 1);
  steps.add({2, gridFeatures()}, {});
  EXPECT_TRUE(std::isnan(steps.lastOverlap()));
  EXPECT_EQ(referenceId(steps), 2);
}

TEST(SequenceOfFrames, SharesFeatures) {
  const auto features = gridFeatures();
  Sequence sequence(previous(2));
  sequence.add({1, features}, {});
  EXPECT_EQ(features.use_count(), 2);
  sequence.add({2, gridFeatures()}, {});
  ASSERT_NE(sequence.reference(), nullptr);
  EXPECT_EQ(sequence.reference()->features, features);
  sequence.add({3, gridFeatures()}, {});
  EXPECT_EQ(features.use_count(), 1);  // no longer needed

  Sequence with_keyframe(keyframes());
  with_keyframe.add({1, features}, {});
  for (int i = 2; i < 10; ++i) {
    const auto passing = gridFeatures();
    with_keyframe.add({std::uint64_t(i), passing}, gridMatches(firstCells(64)));
    EXPECT_LE(passing.use_count(), 2);
  }
  EXPECT_EQ(with_keyframe.reference()->features, features);
  with_keyframe.add({10, gridFeatures()}, {});
  EXPECT_EQ(features.use_count(), 1);
}

TEST(SequenceOfFrames, ForgetsEverything) {
  for (const SequenceOptions& options : {previous(1), previous(3), keyframes()}) {
    const auto features = gridFeatures();
    Sequence sequence(options);
    for (int i = 0; i < 5; ++i) sequence.add({std::uint64_t(i), features}, gridMatches(firstCells(64)));
    ASSERT_NE(sequence.reference(), nullptr);
    sequence.reset();
    EXPECT_EQ(sequence.reference(), nullptr);
    EXPECT_TRUE(std::isnan(sequence.lastOverlap()));
    EXPECT_EQ(features.use_count(), 1);
    // Ids may repeat or go back then, and the features may be of another kind.
    const int first = options.reference == SequenceOptions::Reference::kKeyframe ? 1 : options.step;
    for (int i = 0; i < first; ++i) {
      EXPECT_EQ(sequence.reference(), nullptr);
      sequence.add({std::uint64_t(i), gridFeatures(3)}, {});
    }
    EXPECT_EQ(referenceId(sequence), 0);
  }
}

TEST(SequenceOfFrames, OptionsChangeBetweenFrames) {
  Sequence sequence(previous(3));
  for (int i = 0; i < 10; ++i) sequence.add({std::uint64_t(i), gridFeatures()}, {});
  ASSERT_EQ(referenceId(sequence), 7);
  sequence.setOptions(previous(1));
  EXPECT_EQ(referenceId(sequence), 9);
  // Farther back than is remembered: none until enough have come.
  sequence.setOptions(previous(2));
  EXPECT_EQ(referenceId(sequence), -1);
  sequence.add({10, gridFeatures()}, {});
  EXPECT_EQ(referenceId(sequence), 9);
  // Keyframes begin with the newest frame.
  sequence.setOptions(keyframes());
  EXPECT_EQ(referenceId(sequence), 10);
  sequence.add({11, gridFeatures()}, gridMatches(firstCells(64)));
  EXPECT_EQ(referenceId(sequence), 10);
  sequence.setOptions(keyframes(0.9));  // the keyframe stays
  EXPECT_EQ(referenceId(sequence), 10);
  sequence.setOptions(previous(1));
  EXPECT_EQ(referenceId(sequence), 11);
  // Back to keyframes after a frame without features: there is none.
  sequence.add({12, std::make_shared<Features>()}, {});
  sequence.setOptions(keyframes());
  EXPECT_EQ(referenceId(sequence), -1);
  sequence.add({13, gridFeatures()}, {});
  EXPECT_EQ(referenceId(sequence), 13);
}

TEST(SequenceOfFrames, RefusesWithoutChangingAnything) {
  Sequence sequence(keyframes());
  sequence.add({1, gridFeatures(1)}, {});
  SequenceOptions bad = keyframes();
  bad.reference = SequenceOptions::Reference{7};
  const auto refusal = [&sequence](const SequenceOptions& options) {
    return errorOf<std::invalid_argument>([&] { sequence.setOptions(options); });
  };
  EXPECT_TRUE(contains(refusal(bad), "option reference = '7' is not one of previous, keyframe"));
  EXPECT_TRUE(contains(refusal(previous(0)), "option step = 0 is outside [1, 100]"));
  EXPECT_TRUE(contains(refusal(previous(101)), "option step = 101 is outside [1, 100]"));
  EXPECT_TRUE(contains(refusal(keyframes(1.5)), "option min_overlap = 1.5 is outside [0, 1]"));
  EXPECT_FALSE(errorOf<std::invalid_argument>([&] { Sequence{bad}; }).empty());
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&] {
                         sequence.add({7, nullptr}, {});
                       }),
                       {"frame 7", "features"}));
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] {
                         sequence.add({2, gridFeatures()}, gridMatches({5}));
                       }),
                       "belong to another reference"));
  EXPECT_EQ(referenceId(sequence), 1);
  EXPECT_TRUE(std::isnan(sequence.lastOverlap()));
}

/// Overlap of a view of the left part of an image with the same camera moved to the right by a share of its
/// width, slightly turned and nearer, darker and noisier.
double overlapAfter(double shift, const cv::Mat& image, int width, const FeatureExtractor& extractor) {
  const cv::Size size(width, image.rows);
  const auto left = cvRound(shift * width);
  const cv::Matx23d view(0.98, 0.05, left, -0.05, 0.98, 10);
  cv::Mat moved, noise(size, CV_8S);
  cv::warpAffine(image, moved, view, size, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REFLECT);
  moved.convertTo(moved, -1, 0.9, 10);
  cv::RNG random(1);
  random.fill(noise, cv::RNG::NORMAL, 0, 4);
  cv::add(moved, noise, moved, cv::noArray(), CV_8U);
  const Features reference = extractor.extract(image.colRange(0, width), 2);
  const Features newest = extractor.extract(moved, 2);
  return overlap(matchFeatures(newest, reference, {}, 2), reference, SequenceOptions().ratio);
}

void expectOverlapToFall(const cv::Mat& image, int width) {
  for (const char* name : {"sift+sift", "orb+orb"}) {
    const auto extractor = createExtractor(name);
    const double still = overlapAfter(0, image, width, *extractor);
    const double some = overlapAfter(0.3, image, width, *extractor);
    const double little = overlapAfter(0.6, image, width, *extractor);
    const double none = overlapAfter(1, image, width, *extractor);
    EXPECT_GT(still, 0.7) << name;
    EXPECT_NEAR(some, 0.7, 0.2) << name;
    EXPECT_NEAR(little, 0.4, 0.2) << name;
    EXPECT_LT(none, 0.1) << name;
    // Keyframes are renewed between these at the default.
    EXPECT_GT(some, SequenceOptions().min_overlap) << name;
    EXPECT_LT(little, SequenceOptions().min_overlap) << name;
  }
}

TEST(Overlap, FallsAsTheCameraMoves) {
  cv::Mat image = shapes(1, {900, 420}, 4);
  for (std::uint64_t seed = 5; seed < 9; ++seed) {
    cv::addWeighted(image, 0.7, shapes(1, image.size(), seed), 0.5, -25, image);
  }
  expectOverlapToFall(image, 450);
}

TEST(Overlap, FallsOnPhotographs) {
  const std::string folder = sharedData("vgg");
  if (folder.empty()) GTEST_SKIP() << "VGG is not here";
  for (const char* file : {"graf/img1.ppm", "boat/img1.pgm", "ubc/img1.ppm"}) {
    SCOPED_TRACE(file);
    expectOverlapToFall(cv::imread(folder + "/" + file, cv::IMREAD_GRAYSCALE), 400);
  }
}

TEST(SequenceOfFrames, RenewsKeyframesOnTheRoad) {
  const std::string folder = sharedData("kitti_stereo");
  if (folder.empty()) GTEST_SKIP() << "KITTI is not here";
  const auto extractor = createExtractor("orb+orb");
  Sequence sequence(keyframes());
  std::vector<int> renewed;
  int frames = 0;
  for (;; ++frames) {
    std::string number = std::to_string(frames);
    number.insert(0, 10 - number.size(), '0');
    const cv::Mat image = cv::imread(folder + "/left_" + number + ".png", cv::IMREAD_GRAYSCALE);
    if (image.empty()) break;
    Sequence::Frame frame{std::uint64_t(frames), std::make_shared<Features>(extractor->extract(image, 2))};
    const Sequence::Frame* const reference = sequence.reference();
    Correspondences matches;
    if (reference) matches = matchFeatures(*frame.features, *reference->features, {}, 2);
    sequence.add(std::move(frame), matches);
    if (referenceId(sequence) == frames) renewed.push_back(frames);
    if (frames > 0 && renewed.back() != frames) {
      EXPECT_GE(sequence.lastOverlap(), 0.5) << frames;
    }
  }
  if (frames < 30) GTEST_SKIP() << "few frames of KITTI are here";
  RecordProperty("keyframes", int(renewed.size()));
  EXPECT_GE(renewed.size(), 4u);
  EXPECT_LE(renewed.size(), 15u);
  // Neighbouring frames overlap well.
  for (std::size_t i = 1; i < renewed.size(); ++i) EXPECT_GE(renewed[i] - renewed[i - 1], 2);
}

}  // namespace
}  // namespace corrsel::core
