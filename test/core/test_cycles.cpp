#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "corrsel/database/cycles.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kDegree = CV_PI / 180;

cv::Matx33d turnedBy(const cv::Vec3d& w) {
  const double angle = cv::norm(w);
  if (angle == 0) return cv::Matx33d::eye();
  const cv::Vec3d axis = w * (1 / angle);
  const cv::Matx33d cross(0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0);
  return cv::Matx33d::eye() + cross * std::sin(angle) + cross * cross * (1 - std::cos(angle));
}

cv::Vec3d normalVector(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

cv::Matx33d anyRotation(Random& random) {
  const cv::Vec3d axis = normalVector(random);
  return turnedBy(axis * (random.uniform(0.3, 3) / cv::norm(axis)));
}

/// Images with random rotations, and the pairs among them for which connected(i, j) is true, with noise.
template <class Connected>
std::vector<RelativeRotation> graph(std::uint32_t images, double noise, std::uint64_t seed,
                                    const Connected& connected) {
  Random random(seed);
  std::vector<cv::Matx33d> absolute;
  for (std::uint32_t i = 0; i < images; ++i) absolute.push_back(anyRotation(random));
  std::vector<RelativeRotation> result;
  for (std::uint32_t i = 0; i < images; ++i) {
    for (std::uint32_t j = i + 1; j < images; ++j) {
      if (!connected(i, j)) continue;
      const cv::Matx33d exact = absolute[j] * absolute[i].t();
      result.push_back({{i, j}, turnedBy(normalVector(random) * noise) * exact});
    }
  }
  return result;
}

/// Every image with the next ones of a closed ring.
std::vector<RelativeRotation> ring(std::uint32_t images, std::uint32_t reach, double noise,
                                   std::uint64_t seed) {
  return graph(images, noise, seed,
               [=](std::uint32_t i, std::uint32_t j) { return std::min(j - i, images - (j - i)) <= reach; });
}

/// Images in rows and columns, each with its eight neighbours.
std::vector<RelativeRotation> grid(std::uint32_t side, double noise, std::uint64_t seed) {
  return graph(side * side, noise, seed, [=](std::uint32_t i, std::uint32_t j) {
    const auto difference = [](std::uint32_t a, std::uint32_t b) { return a < b ? b - a : a - b; };
    return std::max(difference(i % side, j % side), difference(i / side, j / side)) <= 1;
  });
}

/// Gives a share of the pairs another rotation. @return their positions
std::set<std::size_t> plant(double share, std::uint64_t seed, std::vector<RelativeRotation>& rotations) {
  Random random(seed);
  const auto order = permutation(rotations.size(), seed);
  std::set<std::size_t> planted(order.begin(), order.begin() + std::lround(share * double(order.size())));
  for (const std::size_t i : planted) rotations[i].rotation = anyRotation(random) * rotations[i].rotation;
  return planted;
}

struct Shares {
  double found = 0, accused = 0;  ///< of the wrong pairs, and of the right ones
};

/// Over several drawings of the wrong pairs.
Shares sharesOf(const std::vector<RelativeRotation>& right, double share) {
  constexpr int kDrawings = 20;
  double wrong = 0, found = 0, accused = 0;
  for (int drawing = 0; drawing < kDrawings; ++drawing) {
    std::vector<RelativeRotation> rotations = right;
    const std::set<std::size_t> planted = plant(share, std::uint64_t(drawing), rotations);
    const CycleReport report = checkCycles(rotations);
    for (std::size_t i = 0; i < rotations.size(); ++i) {
      if (planted.count(i) != 0) ++wrong;
      if (report.pairs[i].accused) ++(planted.count(i) != 0 ? found : accused);
    }
  }
  return {found / wrong, accused / (kDrawings * double(right.size()) - wrong)};
}

TEST(Cycles, TripletsOfRightPairsClose) {
  const CycleReport report = checkCycles(ring(30, 3, 0.3 * kDegree, 1));
  EXPECT_EQ(report.pairs.size(), 90u);
  EXPECT_EQ(report.triplets, 90u);  // (i, i + 1, i + 2), (i, i + 1, i + 3), (i, i + 2, i + 3)
  EXPECT_EQ(report.failing, 0u);
  EXPECT_EQ(report.accused, 0u);
  EXPECT_EQ(report.unchecked, 0u);
  // Three rotations with that noise.
  EXPECT_NEAR(report.noise, std::sqrt(3.0) * 0.3 * kDegree, 0.1 * kDegree);
  EXPECT_GT(report.threshold, 3 * kDegree);
  EXPECT_LT(report.threshold, 5 * kDegree);
}

TEST(Cycles, TheThresholdFollowsTheNoise) {
  const CycleReport report = checkCycles(ring(60, 3, 2 * kDegree, 2));
  EXPECT_NEAR(report.noise, std::sqrt(3.0) * 2 * kDegree, 0.6 * kDegree);
  EXPECT_GT(report.threshold, 12 * kDegree);
  EXPECT_LE(report.accused, 1u);
}

TEST(Cycles, ExactRotationsClose) {
  const CycleReport report = checkCycles(grid(4, 0, 3));
  EXPECT_EQ(report.failing, 0u);
  EXPECT_LT(report.noise, 1e-5);
  EXPECT_NEAR(report.threshold, 3.4 * kDegree, 0.1 * kDegree);
}

TEST(Cycles, AWrongPairIsAccused) {
  std::vector<RelativeRotation> rotations = grid(5, 0.2 * kDegree, 4);
  // (6, 7): both images inside the grid.
  const auto wrong = std::find_if(rotations.begin(), rotations.end(), [](const RelativeRotation& r) {
    return r.pair == ImagePairKey{6, 7};
  });
  wrong->rotation = turnedBy({0, 0.2, 0}) * wrong->rotation;
  const CycleReport report = checkCycles(rotations);
  EXPECT_EQ(report.failing, 4u);
  EXPECT_EQ(report.accused, 1u);
  for (const PairCycles& pair : report.pairs) {
    EXPECT_EQ(pair.accused, (pair.pair == ImagePairKey{6, 7})) << pair.pair.first << ' ' << pair.pair.second;
    EXPECT_EQ(pair.accused, pair.wrong > 0.5);
  }
}

TEST(Cycles, OneTripletDoesNotTellWhichPairIsWrong) {
  const cv::Matx33d turn = turnedBy({0, 1, 0});
  const CycleReport report =
      checkCycles({{{1, 2}, cv::Matx33d::eye()}, {{2, 3}, turn}, {{1, 3}, turn * turn}});
  EXPECT_EQ(report.triplets, 1u);
  EXPECT_EQ(report.failing, 1u);
  EXPECT_EQ(report.accused, 0u);
  for (const PairCycles& pair : report.pairs) EXPECT_EQ(pair.failing, 1u);
}

TEST(Cycles, WithoutTripletsNothingIsSaid) {
  const CycleReport report = checkCycles({{{1, 2}, cv::Matx33d::eye()}, {{2, 3}, cv::Matx33d::eye()}});
  EXPECT_EQ(report.triplets, 0u);
  EXPECT_EQ(report.unchecked, 2u);
  EXPECT_EQ(report.accused, 0u);
  EXPECT_TRUE(std::isnan(report.threshold));
  EXPECT_TRUE(std::isnan(report.noise));
  EXPECT_TRUE(checkCycles({}).pairs.empty());
}

TEST(Cycles, FindPlantedPairs) {
  const auto dense = graph(20, 0.2 * kDegree, 5, [](std::uint32_t, std::uint32_t) { return true; });
  for (const double share : {0.02, 0.1, 0.2}) {
    const Shares shares = sharesOf(dense, share);
    EXPECT_GT(shares.found, 0.99) << share;
    EXPECT_LT(shares.accused, 0.002) << share;
  }
  for (const auto& sparse : {ring(100, 3, 0.2 * kDegree, 6), grid(10, 0.2 * kDegree, 7)}) {
    const Shares few = sharesOf(sparse, 0.02), many = sharesOf(sparse, 0.1);
    EXPECT_GT(few.found, 0.98);
    EXPECT_LT(few.accused, 0.005);
    EXPECT_GT(many.found, 0.93);
    EXPECT_LT(many.accused, 0.02);
  }
}

TEST(Cycles, NoPairIsAccusedWithoutAFailingTriplet) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    std::vector<RelativeRotation> rotations = ring(40, 2, 0.5 * kDegree, seed);
    plant(0.5, seed, rotations);
    for (const PairCycles& pair : checkCycles(rotations).pairs) {
      EXPECT_TRUE(!pair.accused || pair.failing > 0);
      EXPECT_TRUE(pair.failing > 0 || pair.wrong < 0.5) << pair.wrong;
    }
  }
}

TEST(Cycles, DoNotDependOnTheOrderOfTheInput) {
  std::vector<RelativeRotation> rotations = grid(8, 0.3 * kDegree, 8);
  plant(0.15, 9, rotations);
  const CycleReport expected = checkCycles(rotations, 3);
  const CycleReport report = checkCycles(reordered(rotations, permutation(rotations.size(), 10)), 3);
  EXPECT_EQ(report.triplets, expected.triplets);
  EXPECT_EQ(report.threshold, expected.threshold);
  for (std::size_t i = 0; i < report.pairs.size(); ++i) {
    EXPECT_TRUE(report.pairs[i].pair == expected.pairs[i].pair);
    EXPECT_EQ(report.pairs[i].wrong, expected.pairs[i].wrong);
  }
}

TEST(Cycles, FewTripletsOfADensePairAreEnough) {
  std::vector<RelativeRotation> rotations =
      graph(40, 0.2 * kDegree, 11, [](std::uint32_t, std::uint32_t) { return true; });
  const std::set<std::size_t> planted = plant(0.1, 12, rotations);
  const CycleReport report = checkCycles(rotations, 5);
  EXPECT_LE(report.triplets, 5 * rotations.size());
  EXPECT_LT(report.triplets, 9880u);  // all of them
  for (std::size_t i = 0; i < rotations.size(); ++i)
    EXPECT_EQ(report.pairs[i].accused, planted.count(i) != 0) << i;
}

TEST(Cycles, TakeTheRotationOfAVerifiedPair) {
  VerifiedPair pair;
  pair.pair = {4, 9};
  EXPECT_FALSE(relativeRotation(pair));
  pair.geometry.config = TwoViewConfig::kPanoramic;
  pair.geometry.pose = Pose{turnedBy({0.1, 0, 0}), {}};
  const auto rotation = relativeRotation(pair);
  ASSERT_TRUE(rotation);
  EXPECT_TRUE(rotation->pair == pair.pair);
  EXPECT_EQ(cv::norm(rotation->rotation - pair.geometry.pose->rotation), 0);
  pair.faulty = true;
  EXPECT_FALSE(relativeRotation(pair));
}

TEST(Cycles, WrongInputIsNamed) {
  const cv::Matx33d eye = cv::Matx33d::eye();
  const auto message = [](const std::vector<RelativeRotation>& rotations, int max_triplets = 20) {
    return errorOf<std::invalid_argument>([&] { checkCycles(rotations, max_triplets); });
  };
  EXPECT_TRUE(mentions(message({{{1, 2}, eye}, {{1, 2}, eye}}), {"(1, 2)", "twice"}));
  EXPECT_TRUE(mentions(message({{{5, 2}, eye}}), {"(5, 2)", "smaller number first"}));
  EXPECT_TRUE(mentions(message({{{2, 2}, eye}}), {"(2, 2)", "two images"}));
  EXPECT_TRUE(mentions(message({{{1, 2}, eye * 2.0}}), {"(1, 2)", "no rotation"}));
  EXPECT_TRUE(mentions(message({{{1, 2}, eye * -1.0}}), {"(1, 2)", "no rotation"}));
  EXPECT_TRUE(mentions(message({{{1, 2}, eye * std::nan("")}}), {"(1, 2)", "no rotation"}));
  EXPECT_TRUE(mentions(message({}, 0), {"max_triplets", "0", "at least 1"}));
}

}  // namespace
}  // namespace corrsel::core
