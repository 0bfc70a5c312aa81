#include <gtest/gtest.h>

#include "kernels/kernels.h"
#include "selectors/parts/pair_matrix.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

/// Distinct matches with maps, and every value by definition in double precision.
class PairMatrixTest : public ::testing::Test {
 protected:
  ~PairMatrixTest() override { setKernelLevel(before_); }

  void makeMatches(std::size_t n) {
    Random random(n);
    Correspondences m = homographyScene({n, 0.5, 1.0, 3}).matches;
    std::vector<LinearMap> maps;
    std::vector<std::uint32_t> rows;
    for (std::uint32_t i = 0; i < n; ++i) {
      maps.push_back({});
      for (float& value : maps.back()) value = float(random.uniform(-1.5, 1.5));
      rows.push_back(i);
      if (i % 10 == 1) {
        m.left_x[i] = m.left_x[i - 1];
        m.left_y[i] = m.left_y[i - 1];
      }
      if (i % 10 == 3) {
        m.right_x[i] = m.right_x[i - 1];
        m.right_y[i] = m.right_y[i - 1];
      }
    }
    distinct_.assign(m, maps, rows);
    ASSERT_EQ(distinct_.size(), n);
  }

  static double valueOf(const PairColumns& m, PairValue value, const PairRule& rule, std::size_t i,
                        std::size_t j) {
    if (i == j) return 0;
    const double dx = double(m.left_x[j]) - m.left_x[i], dy = double(m.left_y[j]) - m.left_y[i];
    const double du = double(m.right_x[j]) - m.right_x[i], dv = double(m.right_y[j]) - m.right_y[i];
    const double left = std::hypot(dx, dy), right = std::hypot(du, dv);
    if (value == PairValue::kRatio) return std::min(left, right) / std::max(left, right);
    if (rule.one_to_one && (left == 0 || right == 0)) return 0;
    if (value == PairValue::kDifference)
      return std::max(0.0, 1 - double(rule.scale) * (left - right) * (left - right));
    const auto error = [&](std::size_t k) {
      return std::abs(du - m.a11[k] * dx - m.a12[k] * dy) + std::abs(dv - m.a21[k] * dx - m.a22[k] * dy);
    };
    return std::exp2(-double(rule.scale) * std::max(error(i), error(j)));
  }

  DistinctMatches distinct_;
  const Deadline never_{0};

 private:
  KernelLevel before_ = kernelLevel();
};

TEST_F(PairMatrixTest, MultipliesAsDefinedAtEveryLevelAndWithoutMemory) {
  for (const std::size_t n : {1, 2, 15, 16, 17, 100, 301, 2100}) {
    makeMatches(n);
    const PairColumns columns = distinct_.columns();
    std::vector<double> v(n), y(n);
    Random random(n);
    for (double& x : v) x = random.uniform(0, 1);
    for (const PairValue value : {PairValue::kRatio, PairValue::kDifference, PairValue::kPayoff}) {
      for (const bool one_to_one : {false, true}) {
        SCOPED_TRACE(std::to_string(n) + " " + std::to_string(int(value)) + " " + std::to_string(one_to_one));
        PairRule rule;
        rule.one_to_one = one_to_one;
        rule.scale = value == PairValue::kPayoff ? 2e-3F : 1e-4F;
        std::vector<double> expected(n, 0.0), first;
        double sum = 0;
        for (std::size_t i = 0; i < n; ++i) {
          sum += v[i];
          for (std::size_t j = 0; j < n; ++j) expected[i] += valueOf(columns, value, rule, i, j) * v[j];
        }
        for (const KernelLevel level : supportedKernelLevels()) {
          setKernelLevel(level);
          for (const std::size_t limit : {std::size_t{1} << 30, PairMatrix::bytesFor(n) - 1}) {
            PairMatrix matrix;
            matrix.assign(value, rule, columns, n, limit);
            EXPECT_EQ(matrix.isStored(), limit > PairMatrix::bytesFor(n));
            // The first product fills the matrix.
            for (int repetition = 0; repetition < 2; ++repetition) {
              ASSERT_TRUE(matrix.multiply(v.data(), y.data(), never_));
              if (first.empty()) first = y;
              ASSERT_EQ(y, first) << toString(level) << " " << limit;
            }
          }
        }
        // 2^-17 per value, and the rounding of sums in single precision.
        for (std::size_t i = 0; i < n; ++i) ASSERT_NEAR(first[i], expected[i], 7.7e-6 * sum + 1e-5);
      }
    }
  }
}

TEST_F(PairMatrixTest, MultipliesAlikeOnAnyNumberOfThreads) {
  for (const std::size_t n : {300, 2050, 5000}) {
    makeMatches(n);
    std::vector<double> v(n), expected(n), y(n);
    Random random(n);
    for (double& x : v) x = random.uniform(0, 1);
    for (const std::size_t limit : {std::size_t{1} << 30, std::size_t{0}}) {
      PairMatrix alone;
      alone.assign(PairValue::kRatio, {}, distinct_.columns(), n, limit);
      ASSERT_TRUE(alone.multiply(v.data(), expected.data(), never_));
      for (const int threads : {2, 3, 8}) {
        SCOPED_TRACE(std::to_string(n) + " matches, " + std::to_string(threads) + " threads");
        PairMatrix matrix;
        matrix.assign(PairValue::kRatio, {}, distinct_.columns(), n, limit);
        // The second product takes what the threads have stored.
        for (int repetition = 0; repetition < 2; ++repetition) {
          ASSERT_TRUE(matrix.multiply(v.data(), y.data(), never_, threads));
          ASSERT_EQ(y, expected);
        }
        const TickingClock clock(1);
        EXPECT_FALSE(matrix.multiply(v.data(), y.data(), Deadline(1.5), threads));
        ASSERT_TRUE(matrix.multiply(v.data(), y.data(), never_, threads));
        ASSERT_EQ(y, expected);
      }
    }
  }
}

TEST_F(PairMatrixTest, RoundsToTheNearest) {
  makeMatches(400);
  const PairColumns columns = distinct_.columns();
  PairMatrix matrix;
  PairRule rule;
  rule.scale = 2e-3F;
  double bias = 0, worst = 0;
  for (const PairValue value : {PairValue::kRatio, PairValue::kPayoff}) {
    matrix.assign(value, rule, columns, 400, std::size_t{1} << 30);
    std::vector<double> v(400, 0.0), y(400);
    v[7] = 1;
    ASSERT_TRUE(matrix.multiply(v.data(), y.data(), never_));
    for (std::size_t i = 0; i < 400; ++i) {
      const double error = y[i] - valueOf(columns, value, rule, i, 7);
      bias += error / 800;
      worst = std::max(worst, std::abs(error));
    }
  }
  EXPECT_LT(worst, 1.0 / 131072 + 1e-6);
  EXPECT_GT(worst, 0.5 / 131072);
  EXPECT_LT(std::abs(bias), 0.1 / 131072);
}

TEST_F(PairMatrixTest, StopsAtTheDeadlineAndRecovers) {
  makeMatches(1200);
  PairMatrix matrix;
  matrix.assign(PairValue::kRatio, {}, distinct_.columns(), 1200, std::size_t{1} << 30);
  std::vector<double> v(1200, 1.0), y(1200), expected(1200);
  {
    const TickingClock clock(1);
    EXPECT_FALSE(matrix.multiply(v.data(), y.data(), Deadline(0.5))) << "before the first pair";
    EXPECT_FALSE(matrix.multiply(v.data(), y.data(), Deadline(2.5))) << "in the middle";
    EXPECT_EQ(clock.looks(), 6);
  }
  ASSERT_TRUE(matrix.multiply(v.data(), y.data(), never_));
  PairMatrix other;
  other.assign(PairValue::kRatio, {}, distinct_.columns(), 1200, 0);
  ASSERT_TRUE(other.multiply(v.data(), expected.data(), never_));
  EXPECT_EQ(y, expected);
}

TEST_F(PairMatrixTest, IsReusedForOtherSizesAndReleased) {
  PairMatrix matrix;
  std::vector<double> v(300, 1.0), y(300), expected(300);
  for (const std::size_t n : {300, 20, 299}) {
    makeMatches(n);
    matrix.assign(PairValue::kDifference, {1e-4F}, distinct_.columns(), n, std::size_t{1} << 30);
    ASSERT_TRUE(matrix.multiply(v.data(), y.data(), never_));
    matrix.release();
    PairMatrix fresh;
    fresh.assign(PairValue::kDifference, {1e-4F}, distinct_.columns(), n, std::size_t{1} << 30);
    ASSERT_TRUE(fresh.multiply(v.data(), expected.data(), never_));
    EXPECT_EQ(y, expected);
  }
  EXPECT_EQ(PairMatrix::bytesFor(16), 512u);
  EXPECT_EQ(PairMatrix::bytesFor(17), 3 * 512u);
  EXPECT_NEAR(double(PairMatrix::bytesFor(5000)), 25e6, 2e5);
}

TEST_F(PairMatrixTest, DistinctMatchesAreSortedAndCounted) {
  Correspondences m;
  m.add({5, 1}, {2, 2});
  m.add({3, 1}, {2, 2});
  m.add({5, 1}, {2, 2});
  m.add({5, 1}, {2, 1});
  m.add({5, 1}, {2, 2});
  std::vector<LinearMap> maps(5, LinearMap{1, 0, 0, 1});
  maps[4] = {1, 0, 0, 2};
  distinct_.assign(m, {}, {0, 1, 2, 3});
  ASSERT_EQ(distinct_.size(), 3u);
  EXPECT_EQ(distinct_.columns().left_x[0], 3);
  EXPECT_EQ(distinct_.columns().right_y[1], 1);
  EXPECT_EQ(distinct_.columns().size, 16u);
  EXPECT_EQ(distinct_.multiplicity(2), 2u);
  EXPECT_EQ(distinct_.firstRow(2), 0u);
  EXPECT_EQ(distinct_.ofRow(2), 2u);
  EXPECT_EQ(distinct_.ofRow(4), DistinctMatches::kNone);
  distinct_.assign(m, maps, {0, 1, 2, 3, 4});
  EXPECT_EQ(distinct_.size(), 4u);
  EXPECT_EQ(distinct_.columns().a22[3], 2);
  EXPECT_EQ(distinct_.columns({3, 0}).left_x[1], 3);
}

}  // namespace
}  // namespace corrsel::core
