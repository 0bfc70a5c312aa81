#include <gtest/gtest.h>

#include "geometry/fundamental.h"
#include "geometry/residual.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Rows = std::vector<std::uint32_t>;

constexpr std::uint32_t kSample[7] = {0, 1, 2, 3, 4, 5, 6};

/// How far two fundamental matrices of norm 1 are apart, whatever their signs.
double difference(const cv::Matx33d& a, const cv::Matx33d& b) {
  return std::min(cv::norm(a - b), cv::norm(a + b));
}

/// Least difference of the models through the sample to `truth`, both in pixels; Inf without models.
double nearest(const NormalizedMatches& m, const cv::Matx33d& truth) {
  cv::Matx33d f[3];
  const int count = fundamentalFromSeven(m, kSample, f);
  double least = INFINITY;
  for (int k = 0; k < count; ++k) least = std::min(least, difference(m.fundamentalToPixels(f[k]), truth));
  return least;
}

double sumOfErrors(const cv::Matx33d& f, const NormalizedMatches& m) {
  double sum = 0;
  for (std::size_t i = 0; i < m.size(); ++i) {
    sum += sampsonError(f, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
  }
  return sum;
}

TEST(Fundamental, SampsonErrorByHand) {
  // Cameras side by side: x'^T F x = y - y', gradient (0, 1, 0, -1).
  const cv::Matx33d rows(0, 0, 0, 0, 0, -1, 0, 1, 0);
  EXPECT_DOUBLE_EQ(sampsonError(rows, 10, 7, 90, 7), 0);
  EXPECT_DOUBLE_EQ(sampsonError(rows, 10, 7, 90, 4), 4.5);
  EXPECT_DOUBLE_EQ(sampsonError(rows * -3.0, 10, 7, 90, 4), 4.5);
  // Residual (1 2 1) F (3 1 1)^T = 40, F x = (7, 8, 17), F^T x' = (7, 11, 8).
  const cv::Matx33d f(1, 2, 2, 1, 3, 2, 4, 3, 2);
  EXPECT_DOUBLE_EQ(sampsonError(f, 3, 1, 1, 2), 40.0 * 40 / (49 + 64 + 49 + 121));
  // The gradient vanishes: on the constraint or infinitely far from it.
  EXPECT_EQ(sampsonError(cv::Matx33d(0, 0, 0, 0, 0, 0, 0, 0, 1), 1, 2, 3, 4), INFINITY);
  EXPECT_EQ(sampsonError(cv::Matx33d::zeros(), 1, 2, 3, 4), 0);
}

TEST(Fundamental, SampsonErrorsInBlocksAreTheSame) {
  const NormalizedMatches m = normalizeMatches(stereoScene({40, 0.5, 1.0, 2}).matches);
  const cv::Matx33d f(0.1, -0.2, 0.3, 0.25, 0.15, -0.4, -0.35, 0.5, 0.05);
  std::vector<float> errors(30);
  modelErrors(Residual::kSampson, f, m, 5, 35, errors.data());
  for (std::size_t i = 5; i < 35; ++i) {
    const double e = sampsonError(f, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
    EXPECT_NEAR(errors[i - 5], e, 1e-4 * e + 1e-8);
  }
  modelErrors(Residual::kSampson, cv::Matx33d::zeros(), m, 0, 1, errors.data());
  EXPECT_EQ(errors[0], 0.0f);
}

TEST(Fundamental, EpipolarLineDistanceByHand) {
  const cv::Matx33d f(1, 2, 2, 1, 3, 2, 4, 3, 2);
  EXPECT_DOUBLE_EQ(epipolarLineDistance(f, 3, 1, 1, 2), 40 / std::sqrt(49.0 + 64));
  EXPECT_DOUBLE_EQ(epipolarLineDistance(f * -2.0, 3, 1, 1, 2), 40 / std::sqrt(49.0 + 64));
  const cv::Matx33d rows(0, 0, 0, 0, 0, -1, 0, 1, 0);
  EXPECT_DOUBLE_EQ(epipolarLineDistance(rows, 10, 7, 90, 4), 3);
  // The epipole of the left image has no epipolar line.
  EXPECT_TRUE(std::isnan(epipolarLineDistance(cv::Matx33d(0, -1, 2, 1, 0, -3, -2, 3, 0), 3, 2, 5, 5)));
}

TEST(Fundamental, SevenMatchesGiveTheTruthAmongAtMostThree) {
  int found = 0, several = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const Scene scene = stereoScene({7, 1.0, 0.0, seed});
    const NormalizedMatches m = normalizeMatches(scene.matches);
    ASSERT_TRUE(isValidFundamentalSample(m, kSample));
    cv::Matx33d f[3];
    const int count = fundamentalFromSeven(m, kSample, f);
    ASSERT_TRUE(count >= 1 && count <= 3);
    several += count > 1;
    for (int k = 0; k < count; ++k) {
      EXPECT_NEAR(cv::norm(f[k]), 1, 1e-12);
      EXPECT_NEAR(cv::determinant(f[k]), 0, 1e-9);
      for (std::size_t i = 0; i < 7; ++i) {
        const cv::Vec3d line = f[k] * cv::Vec3d(m.left_x[i], m.left_y[i], 1);
        EXPECT_NEAR(line.dot(cv::Vec3d(m.right_x[i], m.right_y[i], 1)), 0, 1e-9);
      }
    }
    found += nearest(m, scene.model) < 1e-2;
  }
  // Rounded coordinates leave some samples without accuracy.
  EXPECT_GE(found, 95);
  EXPECT_GT(several, 10);
}

/// The camera moves forward: 2 units along the line of sight and a little sideways.
const cv::Vec3d kForward(0.3, 0.1, -2);

cv::Matx33d forwardTruth() {
  const cv::Vec3d& t = kForward;
  const cv::Matx33d cross(0, -t[2], t[1], t[2], 0, -t[0], -t[1], t[0], 0);
  return cross * (1.0 / cv::norm(cross));
}

/// A point seen by both cameras at a depth, in units of the focal length.
void addForward(Correspondences& c, Random& random, double depth, double noise) {
  const double y = random.uniform(-0.7, 0.7), x = random.uniform(-0.7, 0.7);
  const cv::Vec3d p = cv::Vec3d(x, y, 1) * depth;
  const cv::Vec3d q = p + kForward;
  c.add({float(p[0] / p[2]), float(p[1] / p[2])},
        {float(q[0] / q[2] + noise * random.normal()), float(q[1] / q[2] + noise * random.normal())});
}

TEST(Fundamental, ModelsWithPointsBehindACameraAreLeftOut) {
  int before = 0, behind = 0;
  Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    for (const bool one_behind : {false, true}) {
      Correspondences c;
      for (int i = 0; i < 7; ++i) {
        // Nearer than 2 is behind the right camera.
        addForward(c, random, one_behind && i == 3 ? random.uniform(0.8, 1.5) : random.uniform(3, 9), 0);
      }
      (one_behind ? behind : before) += nearest(normalizeMatches(c), forwardTruth()) < 1e-2;
    }
  }
  EXPECT_GE(before, 45);
  EXPECT_EQ(behind, 0);
}

TEST(Fundamental, DegenerateSamplesAreRefused) {
  const Correspondences good = stereoScene({7, 1.0, 0.0, 3}).matches;
  cv::Matx33d f[3];
  Correspondences c = good.subset({0, 1, 2, 3, 4, 5, 2});
  EXPECT_FALSE(isValidFundamentalSample(normalizeMatches(c), kSample));
  EXPECT_EQ(fundamentalFromSeven(normalizeMatches(c), kSample, f), 0);
  // Equal in one image only: allowed.
  c = good;
  c.left_x[6] = c.left_x[2];
  c.left_y[6] = c.left_y[2];
  EXPECT_TRUE(isValidFundamentalSample(normalizeMatches(c), kSample));
  // On a line in one image; one point off it is enough.
  for (const bool left : {true, false}) {
    c = good;
    for (std::size_t i = 0; i < 7; ++i)
      (left ? c.left_y : c.right_y)[i] = 0.31f * (left ? c.left_x : c.right_x)[i] + 50;
    EXPECT_FALSE(isValidFundamentalSample(normalizeMatches(c), kSample));
    (left ? c.left_y : c.right_y)[6] += 0.5f;
    EXPECT_TRUE(isValidFundamentalSample(normalizeMatches(c), kSample));
    (left ? c.left_x : c.right_x).assign(7, 4);
    (left ? c.left_y : c.right_y).assign(7, 5);
    EXPECT_FALSE(isValidFundamentalSample(normalizeMatches(c), kSample));
  }
}

/// Such matches give six independent equations and leave a family of solutions, all of which fit.
TEST(Fundamental, IdenticalImagesGetOneOfTheirManySolutions) {
  Correspondences c = stereoScene({20, 1.0, 0.0, 3}).matches;
  c.right_x = c.left_x;
  c.right_y = c.left_y;
  const NormalizedMatches m = normalizeMatches(c);
  cv::Matx33d f[3];
  ASSERT_EQ(fundamentalFromSeven(m, kSample, f), 1);
  EXPECT_NEAR(cv::norm(f[0]), 1, 1e-12);
  EXPECT_NEAR(cv::norm(f[0] + f[0].t()), 0, 1e-9);
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_LT(sampsonError(f[0], m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]), 1e-12);
  }
}

/// A model through seven matches, refined on all those within the threshold; zeros where the seven give none.
cv::Matx33d refined(const NormalizedMatches& m, float squared_threshold, int steps = 10) {
  cv::Matx33d models[3];
  const int count = fundamentalFromSeven(m, kSample, models);
  if (count == 0) return cv::Matx33d::zeros();
  const auto truncated = [&m, squared_threshold](const cv::Matx33d& f) {
    std::vector<float> errors(m.size());
    modelErrors(Residual::kSampson, f, m, 0, m.size(), errors.data());
    double sum = 0;
    for (const float error : errors) sum += std::min(error, squared_threshold);
    return sum;
  };
  cv::Matx33d best = models[0];
  for (int k = 1; k < count; ++k) best = truncated(models[k]) < truncated(best) ? models[k] : best;
  for (int step = 0; step < steps; ++step) EXPECT_TRUE(refineFundamental(m, squared_threshold, best));
  return best;
}

TEST(Fundamental, RefinementIsExactOnExactData) {
  for (const std::size_t n : {20, 200}) {
    const Scene scene = stereoScene({n, 1.0, 0.0, 4});
    const NormalizedMatches m = normalizeMatches(scene.matches);
    const cv::Matx33d f = refined(m, INFINITY);
    EXPECT_NEAR(cv::norm(f), 1, 1e-12);
    const cv::Matx33d pixels = m.fundamentalToPixels(f);
    EXPECT_NEAR(cv::norm(pixels), 1, 1e-12);
    EXPECT_LT(difference(pixels, scene.model), 1e-4);
  }
}

TEST(Fundamental, RefinementUsesTheInliersOnly) {
  const Scene scene = stereoScene({200, 0.5, 0.0, 4});  // the first half is right
  const NormalizedMatches m = normalizeMatches(scene.matches);
  const auto threshold = static_cast<float>(std::pow(2 * m.scale, 2));
  EXPECT_LT(difference(m.fundamentalToPixels(refined(m, threshold)), scene.model), 1e-3);
}

TEST(Fundamental, RefinementBeatsMinimalModelsAndHasRankTwo) {
  double fitted = 0, minimal = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const Scene noisy = stereoScene({80, 1.0, 1.0, seed});
    // The same points without noise measure the quality of a model.
    const Scene exact = stereoScene({80, 1.0, 0.0, seed + 1000});
    const NormalizedMatches m = normalizeMatches(noisy.matches);
    const auto distance = [&exact, &m](const cv::Matx33d& f) {
      double sum = 0;
      for (std::size_t i = 0; i < 80; ++i) {
        const Correspondences& e = exact.matches;
        sum +=
            lineDistance(m.fundamentalToPixels(f), {e.left_x[i], e.left_y[i]}, {e.right_x[i], e.right_y[i]});
      }
      return sum / 80;
    };
    cv::Matx33d few[3];
    const int count = fundamentalFromSeven(m, kSample, few);
    if (count == 0) continue;
    const cv::Matx33d all = refined(m, INFINITY);
    EXPECT_NEAR(cv::determinant(all), 0, 1e-12);
    double best = INFINITY;
    for (int k = 0; k < count; ++k) best = std::min(best, distance(few[k]));
    minimal += std::min(best, 100.0);
    fitted += distance(all);
  }
  EXPECT_LT(fitted, 0.3 * minimal);
  EXPECT_LT(fitted / 30, 1.0);
}

TEST(Fundamental, RefinementLowersTheSampsonDistances) {
  // Compared with the plain eight-point algorithm (one round), the sum of Sampson distances is lower.
  double weighted = 0, plain = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Correspondences c;
    for (int i = 0; i < 40; ++i) addForward(c, random, random.uniform(3, 20), 0.003);
    const NormalizedMatches m = normalizeMatches(c);
    const cv::Matx33d f = refined(m, INFINITY);
    if (f == cv::Matx33d::zeros()) continue;
    weighted += sumOfErrors(f, m);
    cv::Mat a(40, 9, CV_64F), w, u, vt;
    for (int i = 0; i < 40; ++i) {
      const std::size_t k = std::size_t(i);
      const double x = m.left_x[k], y = m.left_y[k], s = m.right_x[k], t = m.right_y[k];
      cv::Mat(cv::Matx<double, 1, 9>(s * x, s * y, s, t * x, t * y, t, x, y, 1)).copyTo(a.row(i));
    }
    cv::SVD::compute(a, w, u, vt);
    cv::Mat eight = vt.row(8).reshape(1, 3).clone();
    cv::SVD::compute(eight, w, u, vt);
    w.at<double>(2) = 0;
    eight = u * cv::Mat::diag(w) * vt;
    plain += sumOfErrors(cv::Matx33d(eight.ptr<double>()), m);
  }
  EXPECT_LT(weighted, 0.99 * plain);
}

TEST(Fundamental, RefinementRefusesWhatCannotBeFitted) {
  const NormalizedMatches m = normalizeMatches(stereoScene({20, 1.0, 0.0, 6}).matches);
  cv::Matx33d models[3];
  ASSERT_GT(fundamentalFromSeven(m, kSample, models), 0);
  cv::Matx33d f = models[0];
  EXPECT_FALSE(refineFundamental(m, -1.0F, f));  // no inlier
  EXPECT_EQ(f, models[0]);
  Correspondences same;
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const cv::Point2f p = uniformPoint(random, 800, 600);
    same.add(p, p);
  }
  const cv::Matx33d skew(0, -0.5, 0.5, 0.5, 0, -0.5, -0.5, 0.5, 0);
  f = skew;  // one of the many that identical images allow
  EXPECT_FALSE(refineFundamental(normalizeMatches(same), INFINITY, f));
  EXPECT_EQ(f, skew);
}

TEST(Fundamental, LeftNullVectorIsTheRightEpipole) {
  const Scene scene = stereoScene({20, 1.0, 0.0, 6});
  const cv::Vec3d epipole = leftNullVector(scene.model);
  EXPECT_LT(cv::norm(scene.model.t() * epipole), 1e-9 * cv::norm(epipole));
  EXPECT_GT(cv::norm(epipole), 0);
  EXPECT_EQ(leftNullVector(cv::Matx33d(1, 2, 3, 2, 4, 6, 3, 6, 9)), cv::Vec3d(0, 0, 0));
}

}  // namespace
}  // namespace corrsel::core
