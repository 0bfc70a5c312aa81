#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "corrsel/evaluation/truth_check.h"
#include "corrsel/random.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::projected;

constexpr int kWidth = 800, kHeight = 600;
const cv::Matx33d kHomography(0.95, 0.12, 40, -0.1, 0.9, 25, 1e-4, -5e-5, 1);
// The camera moves to the right and forward, and turns a little.
const cv::Matx33d kFundamental(1e-8, -4e-6, 1e-3, 3e-6, 2e-8, -9e-3, -1.5e-3, 8e-3, 0.2);

/// Matches of which the first `right` have their right point at to(left); the others are anywhere.
Correspondences matchesOf(std::size_t right, std::size_t wrong,
                          const std::function<cv::Point2d(const cv::Point2d&, Random&)>& to,
                          std::uint64_t seed = 1) {
  Random random(seed);
  Correspondences matches;
  matches.left_size = matches.right_size = {kWidth, kHeight};
  const auto anywhere = [&random] {
    const double x = random.uniform(0, kWidth), y = random.uniform(0, kHeight);
    return cv::Point2d(x, y);
  };
  for (std::size_t i = 0; i < right + wrong; ++i) {
    const cv::Point2d left = anywhere(), other = anywhere();
    matches.add(left, i < right ? to(left, random) : other);
  }
  return matches;
}

Correspondences planeMatches(const cv::Matx33d& h, std::size_t right, std::size_t wrong,
                             std::uint64_t seed = 1) {
  return matchesOf(
      right, wrong, [&h](const cv::Point2d& left, Random&) { return projected(h, left.x, left.y); }, seed);
}

/// Right points anywhere on the epipolar lines.
Correspondences spaceMatches(const cv::Matx33d& f, std::size_t right, std::size_t wrong) {
  return matchesOf(right, wrong, [&f](const cv::Point2d& left, Random& random) {
    const cv::Vec3d line = f * cv::Vec3d(left.x, left.y, 1);
    const double along = random.uniform(0, 1);
    if (std::abs(line[0]) > std::abs(line[1])) {
      return cv::Point2d(-(line[1] * along * kHeight + line[2]) / line[0], along * kHeight);
    }
    return cv::Point2d(along * kWidth, -(line[0] * along * kWidth + line[2]) / line[1]);
  });
}

GroundTruth truthOf(TruthKind kind, const cv::Matx33d& matrix) {
  GroundTruth truth;
  truth.kind = kind;
  truth.matrix = matrix;
  return truth;
}

/// The rows of a pair of the sequence set/desk.
std::vector<TruthCheck> checked(const GroundTruth& truth, const Correspondences& matches,
                                const std::string& pair = "1-2",
                                const std::vector<OtherReading>& other_readings = {}) {
  std::vector<TruthCheck> checks = checkTruth(truth, other_readings, matches);
  for (TruthCheck& check : checks) check.id = {"set", "desk", pair};
  return checks;
}

/// The reading that is reported; empty if none is, "several" if more than one is.
std::string reported(const std::vector<TruthCheck>& checks) {
  const std::vector<TruthWarning> warnings = truthWarnings(checks);
  if (warnings.size() > 1) return "several";
  return warnings.empty() ? "" : warnings.front().counts.reading;
}

std::string reportedOf(TruthKind kind, const cv::Matx33d& given, const Correspondences& matches) {
  return reported(checked(truthOf(kind, given), matches));
}

cv::Matx33d exchanged(const cv::Matx33d& matrix) {
  const cv::Matx33d exchange(0, 1, 0, 1, 0, 0, 0, 0, 1);
  return exchange * matrix * exchange;
}

TEST(TruthCheck, EveryMistakeWithAHomographyIsNamed) {
  const Correspondences matches = planeMatches(kHomography, 300, 500);
  const auto report = [&](const cv::Matx33d& given) {
    return reportedOf(TruthKind::kHomography, given, matches);
  };
  EXPECT_EQ(report(kHomography), "");
  EXPECT_EQ(report(kHomography * -3), "");
  EXPECT_EQ(report(kHomography.inv()), "inverse");
  EXPECT_EQ(report(kHomography.inv() * -2), "inverse");
  EXPECT_EQ(report(kHomography.t()), "transpose");
  EXPECT_EQ(report(kHomography.inv().t()), "inverse_transpose");
  EXPECT_EQ(report(exchanged(kHomography)), "exchanged_axes");
  const cv::Matx33d to_pixels(kWidth, 0, 0, 0, kHeight, 0, 0, 0, 1);
  EXPECT_EQ(report(to_pixels.inv() * kHomography * to_pixels), "unit_square");
  EXPECT_EQ(report(cv::Matx33d(0.5, 0, 300, 0, 0.5, 0, 0, 0, 1)), "");  // no reading explains the matches
}

TEST(TruthCheck, EveryMistakeWithAFundamentalMatrixIsNamed) {
  const Correspondences matches = spaceMatches(kFundamental, 300, 500);
  const auto report = [&](const cv::Matx33d& given) {
    return reportedOf(TruthKind::kFundamental, given, matches);
  };
  EXPECT_EQ(report(kFundamental), "");
  EXPECT_EQ(report(kFundamental.t()), "transpose");
  EXPECT_EQ(report(exchanged(kFundamental)), "exchanged_axes");
  const cv::Matx33d to_pixels(kWidth, 0, 0, 0, kHeight, 0, 0, 0, 1);
  EXPECT_EQ(report(to_pixels * kFundamental * to_pixels), "unit_square");
}

TEST(TruthCheck, EveryMistakeWithADisparityIsNamed) {
  // The right x of a left point is 0.7 x - 20 - 0.1 y.
  cv::Mat left_disparity(kHeight, kWidth, CV_32F), right_disparity(kHeight, kWidth, CV_32F);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      left_disparity.at<float>(y, x) = static_cast<float>(0.3 * x + 20 + 0.1 * y);
      right_disparity.at<float>(y, x) = static_cast<float>((x + 20 + 0.1 * y) / 0.7 - x);
    }
  }
  const Correspondences matches = matchesOf(300, 500, [](const cv::Point2d& left, Random&) {
    return cv::Point2d(0.7 * left.x - 20 - 0.1 * left.y, left.y);
  });
  const auto report = [&](const cv::Mat& given) {
    GroundTruth truth;
    truth.kind = TruthKind::kDisparity;
    truth.disparity = given;
    return reported(checked(truth, matches));
  };
  EXPECT_EQ(report(left_disparity), "");
  EXPECT_EQ(report(left_disparity * -1), "opposite_sign");
  EXPECT_EQ(report(left_disparity * 16), "sixteenths");
  EXPECT_EQ(report(left_disparity * 256), "256ths");
  EXPECT_EQ(report(right_disparity), "right_image");
}

TEST(TruthCheck, LabelsAndPairsWithoutTruthHaveNoReadings) {
  GroundTruth labels;
  labels.kind = TruthKind::kLabels;
  labels.labels.assign(800, 0);
  const Correspondences matches = planeMatches(kHomography, 300, 500);
  EXPECT_TRUE(checked(labels, matches).empty());
  EXPECT_TRUE(checked({}, matches).empty());
  EXPECT_TRUE(checked(truthOf(TruthKind::kHomography, kHomography), {}).empty());
}

TEST(TruthCheck, SymmetricSituationsAreInOrder) {
  const cv::Matx33d identity = cv::Matx33d::eye();
  EXPECT_EQ(reportedOf(TruthKind::kHomography, identity, planeMatches(identity, 500, 100)), "");
  // The inverse moves points by 2 px the other way.
  const cv::Matx33d shift(1, 0, 1, 0, 1, 0, 0, 0, 1);
  EXPECT_EQ(reportedOf(TruthKind::kHomography, shift.inv(), planeMatches(shift, 500, 100)), "");
  const cv::Matx33d rectified(0, 0, 0, 0, 0, -1, 0, 1, 0);
  EXPECT_EQ(reportedOf(TruthKind::kFundamental, rectified.t(), spaceMatches(rectified, 500, 100)), "");
}

TEST(TruthCheck, TooFewMatchesProveNothing) {
  const auto report = [](std::size_t right) {
    return reportedOf(TruthKind::kHomography, kHomography.inv(), planeMatches(kHomography, right, 0));
  };
  EXPECT_EQ(report(24), "");
  EXPECT_EQ(report(40), "inverse");
}

TEST(TruthCheck, OutliersProveNothing) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Correspondences wrong = planeMatches(kHomography, 0, 3000, seed);
    EXPECT_EQ(reportedOf(TruthKind::kFundamental, kFundamental, wrong), "") << seed;
    EXPECT_EQ(reportedOf(TruthKind::kFundamental, kFundamental.t(), wrong), "") << seed;
    EXPECT_EQ(reportedOf(TruthKind::kHomography, kHomography, wrong), "") << seed;
  }
}

/// The truth's lines pass outside of the image and those of its transpose inside, so that only these have
/// outliers by chance.
TEST(TruthCheck, ChanceIsTakenOff) {
  const cv::Matx33d outside(0, 0, 0, 0, 0, -1, 0, 1e-3, 2000);  // y' = 2000 + y / 1000
  const Correspondences wrong = planeMatches(kHomography, 0, 8000);
  const std::vector<TruthCheck> checks = checked(truthOf(TruthKind::kFundamental, kFundamental), wrong);
  ASSERT_FALSE(checks.empty());
  EXPECT_GT(checks[0].n_truth_by_chance, 50u);
  EXPECT_NEAR(static_cast<double>(checks[0].n_truth), static_cast<double>(checks[0].n_truth_by_chance), 60);
  TruthCheck given = checks[0];
  given.n_truth = given.n_truth_by_chance = 0;
  given.n_reading = given.n_reading_by_chance = 130;
  EXPECT_EQ(reported({given}), "");
  given.n_reading_by_chance = 0;
  EXPECT_EQ(reported({given}), "transpose");
  EXPECT_EQ(reportedOf(TruthKind::kFundamental, outside, wrong), "");
}

TEST(TruthCheck, AReadingMustExplainTwiceAsMuch) {
  TruthCheck counts;
  counts.id = {"set", "desk", "1-2"};
  counts.kind = TruthKind::kHomography;
  counts.reading = "inverse";
  counts.n_putative = 4000;
  counts.n_truth = 1000;
  counts.n_reading = 1900;
  EXPECT_EQ(reported({counts}), "");
  counts.n_reading = 2100;
  EXPECT_EQ(reported({counts}), "inverse");
}

TEST(TruthCheck, PairsOfASequenceAreAddedUp) {
  std::vector<TruthCheck> checks;
  for (const char* pair : {"1-2", "1-3", "1-4"}) {
    const std::vector<TruthCheck> more =
        checked(truthOf(TruthKind::kHomography, kHomography.inv()), planeMatches(kHomography, 20, 300), pair);
    EXPECT_EQ(reported(more), "");
    checks.insert(checks.end(), more.begin(), more.end());
  }
  const std::vector<TruthWarning> warnings = truthWarnings(checks);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].id, (PairId{"set", "desk", ""}));
  EXPECT_EQ(warnings[0].pairs, 3u);
  EXPECT_EQ(warnings[0].text().find("set/desk: "), 0u);
  EXPECT_TRUE(
      contains(warnings[0].text(), " of 960 putative matches agree with the homographies within 5 px, "))
      << warnings[0].text();
}

TEST(TruthCheck, OneWrongPairOfASequenceIsFound) {
  std::vector<TruthCheck> checks;
  for (const char* pair : {"1-2", "1-3", "1-4", "1-5"}) {
    const bool wrong = pair == std::string("1-4");
    const cv::Matx33d given = wrong ? kHomography.inv() : kHomography;
    const std::vector<TruthCheck> more =
        checked(truthOf(TruthKind::kHomography, given), planeMatches(kHomography, 200, 300), pair);
    checks.insert(checks.end(), more.begin(), more.end());
  }
  const std::vector<TruthWarning> warnings = truthWarnings(checks);
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].id, (PairId{"set", "desk", "1-4"}));
  EXPECT_EQ(warnings[0].counts.n_reading, 200u);
}

TEST(TruthCheck, TextsHaveBothCounts) {
  TruthWarning warning;
  warning.id = {"own", "desk", ""};
  warning.pairs = 1;
  warning.counts.kind = TruthKind::kHomography;
  warning.counts.reading = "inverse";
  warning.counts.n_putative = 800;
  warning.counts.n_truth = 12;
  warning.counts.n_reading = 640;
  EXPECT_EQ(
      warning.text(),
      "own/desk: 12 of 800 putative matches agree with the homography within 5 px, 640 with the inverse; "
      "the matrix probably maps from right to left");
  warning.counts.reading = "transpose";
  EXPECT_TRUE(
      contains(warning.text(), "640 with the transpose; the matrix is probably written column by column"));
  warning.counts.kind = TruthKind::kFundamental;
  EXPECT_TRUE(contains(warning.text(), "the matrix probably belongs to the images in the opposite order"));
  warning.counts.reading = "raw";
  EXPECT_TRUE(contains(warning.text(), "640 with the images taken as raw; the images are probably raw"));
  warning.counts.reading = "something else";
  EXPECT_TRUE(contains(warning.text(), "640 in another reading; "));
}

TEST(TruthCheck, SourcesCanAddReadings) {
  const Correspondences matches = planeMatches(kHomography, 300, 500);
  OtherReading raw{"raw", truthOf(TruthKind::kHomography, cv::Matx33d::eye()), nullptr, 2.0};
  raw.moved = [](const Correspondences& given) {
    Correspondences moved = given;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      const cv::Point2d to = projected(kHomography, given.left_x[i], given.left_y[i]);
      moved.left_x[i] = i == 0 ? NAN : static_cast<float>(to.x);
      moved.left_y[i] = static_cast<float>(to.y);
    }
    return moved;
  };
  // Off by 3 px, which makes no difference at the tolerance of the other readings.
  const cv::Matx33d shift(1, 0, 3, 0, 1, 0, 0, 0, 1);
  const GroundTruth wrong = truthOf(TruthKind::kHomography, shift * kHomography);
  const std::vector<TruthWarning> warnings = truthWarnings(checked(wrong, matches, "1-2", {raw}));
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_EQ(warnings[0].counts.reading, "raw");
  EXPECT_EQ(warnings[0].counts.tolerance, 2.0);
  EXPECT_EQ(warnings[0].counts.n_reading, 299u);  // the point that the images do not have does not count
}

}  // namespace
}  // namespace corrsel::core
