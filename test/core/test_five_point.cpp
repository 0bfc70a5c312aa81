#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <opencv2/core.hpp>
#include <vector>

#include "corrsel/evaluation/statistics.h"
#include "corrsel/random.h"
#include "geometry/cross_matrix.h"
#include "geometry/five_point.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Restores the kernel level that was in use.
class FivePoint : public ::testing::Test {
 protected:
  ~FivePoint() override { setKernelLevel(before_); }

 private:
  KernelLevel before_ = kernelLevel();
};

using Solutions = std::vector<cv::Matx33d>;

/// Solves in batches of `batch`.
std::vector<Solutions> solve(const std::vector<FivePointSample>& samples, int batch = kFivePointBatch) {
  std::vector<Solutions> result;
  for (std::size_t begin = 0; begin < samples.size(); begin += std::size_t(batch)) {
    cv::Matx33d found[kFivePointBatch][kFivePointSolutions];
    int counts[kFivePointBatch];
    const int count = std::min(batch, int(samples.size() - begin));
    essentialsFromFive(samples.data() + begin, count, found, counts);
    for (int k = 0; k < count; ++k) result.emplace_back(found[k], found[k] + counts[k]);
  }
  return result;
}

cv::Vec3d randomDirection(Random& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return cv::normalize(cv::Vec3d(x, y, z));
}

cv::Matx33d rotationAbout(const cv::Vec3d& axis, double angle) {
  const cv::Matx33d k = crossMatrix(axis);
  return cv::Matx33d::eye() + std::sin(angle) * k + (1 - std::cos(angle)) * k * k;
}

void setRays(FivePointSample& sample, int match, const cv::Vec3d& left, const cv::Vec3d& right) {
  std::copy_n(cv::normalize(left).val, 3, sample.left[match]);
  std::copy_n(cv::normalize(right).val, 3, sample.right[match]);
}

struct PosedSample {
  FivePointSample sample;
  cv::Matx33d essential;  ///< of norm 1
};

/// Five points within the angle of view of the left camera, and a second camera at most 15 degrees turned.
PosedSample randomSample(Random& random, double tangent_of_view) {
  PosedSample result;
  const cv::Vec3d axis = randomDirection(random), step = randomDirection(random);
  const cv::Matx33d rotation = rotationAbout(axis, random.uniform(0, 0.26));
  const cv::Vec3d translation = random.uniform(0.4, 4) * step;
  for (int k = 0; k < 5; ++k) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), depth = random.uniform(4, 12);
    const cv::Vec3d point = depth * cv::Vec3d(tangent_of_view * x, tangent_of_view * y, 1);
    setRays(result.sample, k, point, rotation * point + translation);
  }
  result.essential = crossMatrix(translation) * rotation;
  result.essential *= 1 / cv::norm(result.essential);
  return result;
}

/// Every second one narrow: 23 degrees instead of 90.
std::vector<PosedSample> randomSamples(std::size_t n) {
  Random random(1);
  std::vector<PosedSample> result;
  for (std::size_t i = 0; i < n; ++i) result.push_back(randomSample(random, i % 2 == 0 ? 1.0 : 0.2));
  return result;
}

std::vector<FivePointSample> samplesOf(const std::vector<PosedSample>& posed) {
  std::vector<FivePointSample> result;
  for (const PosedSample& each : posed) result.push_back(each.sample);
  return result;
}

/// The sign is arbitrary. Without solutions 1.
double distanceToNearest(const Solutions& solutions, const cv::Matx33d& truth) {
  double nearest = 1;
  for (const cv::Matx33d& e : solutions)
    nearest = std::min({nearest, cv::norm(e - truth), cv::norm(e + truth)});
  return nearest;
}

/// The largest deviation from norm 1, the five equations, the trace constraint and det E = 0.
double violation(const FivePointSample& sample, const cv::Matx33d& e) {
  double worst = std::abs(cv::norm(e) - 1);
  for (int k = 0; k < 5; ++k) {
    const cv::Vec3d left(sample.left[k]), right(sample.right[k]);
    worst = std::max(worst, std::abs(right.dot(e * left)));
  }
  const cv::Matx33d square = e * e.t();
  worst = std::max(worst, cv::norm(2.0 * square * e - cv::trace(square) * e));
  return std::max(worst, std::abs(cv::determinant(e)));
}

/// Bit for bit.
bool areSame(const std::vector<Solutions>& a, const std::vector<Solutions>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const Solutions& p, const Solutions& q) {
    return p.size() == q.size() &&
           (p.empty() || std::memcmp(p.data(), q.data(), p.size() * sizeof p[0]) == 0);
  });
}

TEST_F(FivePoint, FindsBothSolutionsOfAKnownScene) {
  const cv::Vec3d points[5] = {{-1, -.5, 4}, {1.2, .4, 5}, {.3, -1.1, 6}, {-.7, .9, 3.5}, {.5, .6, 4.5}};
  const cv::Vec3d turn(0.10, -0.20, 0.05), translation = cv::normalize(cv::Vec3d(1, 0.5, -0.25));
  const cv::Matx33d rotation = rotationAbout(cv::normalize(turn), cv::norm(turn));
  FivePointSample sample;
  for (int k = 0; k < 5; ++k) setRays(sample, k, points[k], rotation * points[k] + translation);
  const std::vector<Solutions> found = solve({sample});
  ASSERT_EQ(found[0].size(), 2u);
  const cv::Matx33d expected[2] = {
      {0.068062383655, 0.182398218425, 0.284861406467, -0.274940406917, -0.048925973790, -0.571643181097,
       -0.277631279216, 0.631740926121, -0.003840736327},
      {0.009932461428, 0.157688016920, 0.669072085441, -0.228532477076, -0.065578005148, 0.177574058589,
       -0.602108681624, -0.276781181583, 0.013250619856}};
  for (const cv::Matx33d& e : expected) EXPECT_LT(distanceToNearest(found[0], e), 1e-11);
}

TEST_F(FivePoint, FindsTheTruePoseOfExactRays) {
  const std::vector<PosedSample> posed = randomSamples(20000);
  const std::vector<Solutions> found = solve(samplesOf(posed));
  std::vector<double> distances;
  double solutions = 0;
  for (std::size_t i = 0; i < posed.size(); ++i) {
    distances.push_back(distanceToNearest(found[i], posed[i].essential));
    solutions += double(found[i].size());
  }
  const auto close = std::count_if(distances.begin(), distances.end(), [](double d) { return d < 1e-6; });
  EXPECT_LT(quantile(distances, 0.5), 1e-12);
  EXPECT_GE(double(close), 0.97 * double(posed.size()));
  EXPECT_GT(solutions, 4.0 * double(posed.size()));
}

TEST_F(FivePoint, SolutionsAreEssentialMatrices) {
  const std::vector<PosedSample> posed = randomSamples(20000);
  const std::vector<Solutions> found = solve(samplesOf(posed));
  std::vector<double> violations;
  for (std::size_t i = 0; i < posed.size(); ++i) {
    for (const cv::Matx33d& e : found[i]) violations.push_back(violation(posed[i].sample, e));
  }
  EXPECT_LT(quantile(violations, 0.5), 1e-12);
  EXPECT_LT(quantile(violations, 0.99), 1e-6);
}

TEST_F(FivePoint, LevelsGiveTheSameBits) {
  const std::vector<FivePointSample> samples = samplesOf(randomSamples(2000));
  setKernelLevel(KernelLevel::kPlain);
  const std::vector<Solutions> expected = solve(samples);
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    EXPECT_TRUE(areSame(solve(samples), expected)) << toString(level);
  }
}

TEST_F(FivePoint, SamplesDoNotDependOnTheirBatch) {
  const std::vector<FivePointSample> samples = samplesOf(randomSamples(840));
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    const std::vector<Solutions> expected = solve(samples);
    for (int batch = 1; batch < kFivePointBatch; ++batch)
      EXPECT_TRUE(areSame(solve(samples, batch), expected)) << toString(level) << " " << batch;
  }
}

/// Samples without a finite number of solutions, among them every kind of match that the search may draw.
std::vector<FivePointSample> degenerateSamples() {
  const FivePointSample good = randomSamples(1)[0].sample;
  std::vector<FivePointSample> result;
  FivePointSample sample = good;
  for (int k = 1; k < 5; ++k) {
    std::copy_n(good.left[0], 3, sample.left[k]);
    std::copy_n(good.right[0], 3, sample.right[k]);
  }
  result.push_back(sample);  // one match five times
  sample = good;
  std::copy_n(good.left[0], 3, sample.left[1]);
  std::copy_n(good.right[0], 3, sample.right[1]);
  result.push_back(sample);  // one match twice
  for (int k = 0; k < 5; ++k) setRays(sample, k, {0.1 * k, 0.2 * k - 0.3, 1}, {0.1 * k - 0.05, 0.3, 1});
  result.push_back(sample);  // on one line in both images
  for (int k = 0; k < 5; ++k) std::copy_n(good.left[k], 3, sample.right[k]);
  for (int k = 0; k < 5; ++k) std::copy_n(good.left[k], 3, sample.left[k]);
  result.push_back(sample);  // at rest
  result.push_back({});      // zeros
  for (const double value : {kNan, std::numeric_limits<double>::infinity(), 1e-200, 1e200}) {
    sample = good;
    sample.left[2][1] = value;
    result.push_back(sample);
    sample = good;
    sample.right[4][2] = value;
    result.push_back(sample);
  }
  return result;
}

TEST_F(FivePoint, DegenerateSamplesGiveFiniteSolutionsAndDisturbNoOthers) {
  const std::vector<FivePointSample> degenerate = degenerateSamples();
  const std::vector<FivePointSample> good = samplesOf(randomSamples(degenerate.size()));
  std::vector<FivePointSample> mixed;
  for (std::size_t i = 0; i < good.size(); ++i) mixed.insert(mixed.end(), {degenerate[i], good[i]});
  setKernelLevel(KernelLevel::kPlain);
  const std::vector<Solutions> undisturbed = solve(good), plain = solve(mixed);
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    const std::vector<Solutions> found = solve(mixed);
    EXPECT_TRUE(areSame(found, plain)) << toString(level);
    std::vector<Solutions> others;
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (i % 2 != 0) others.push_back(found[i]);
      for (const cv::Matx33d& e : found[i]) EXPECT_NEAR(cv::norm(e), 1, 1e-12) << i;
    }
    EXPECT_TRUE(areSame(others, undisturbed)) << toString(level);
  }
}

TEST_F(FivePoint, RaysThatDoNotExistHaveNoSolution) {
  for (int match = 0; match < 5; ++match) {
    FivePointSample sample = randomSamples(1)[0].sample;
    EXPECT_FALSE(solve({sample})[0].empty());
    sample.right[match][0] = kNan;
    EXPECT_TRUE(solve({sample})[0].empty()) << match;
  }
}

}  // namespace
}  // namespace corrsel::core
