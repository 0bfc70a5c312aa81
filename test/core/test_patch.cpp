#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr int kSide = Patch::kSide, kPitch = Patch::kPitch, kInner = Patch::kInner;
constexpr int kWidth = 90, kHeight = 70, kStride = 96;

/// Compares the results of all supported levels with those of plain loops, and restores the level in use.
class PatchKernelsTest : public ::testing::Test {
 protected:
  ~PatchKernelsTest() override { setKernelLevel(before_); }

  template <class Check>
  void atEveryLevel(const Check& check) {
    for (const KernelLevel level : supportedKernelLevels()) {
      setKernelLevel(level);
      SCOPED_TRACE(toString(level));
      check(kernels().patches);
    }
  }

 private:
  KernelLevel before_ = kernelLevel();
};

std::vector<std::int16_t> randomPixels(std::uint64_t seed) {
  Random random(seed);
  std::vector<std::int16_t> pixels(std::size_t{kHeight} * kStride);
  for (std::int16_t& pixel : pixels) pixel = std::int16_t(random.uniform(0, 32641));
  return pixels;
}

Patch randomPatch(std::uint64_t seed, int smoothness = 1) {
  Random random(seed);
  Patch patch = {};
  for (int r = 0; r < kSide; ++r) {
    for (int c = 0; c < kPitch; ++c) {
      float& value = patch.values[r * kPitch + c];
      value = c < kSide ? float(random.uniform(0, 255)) : patch.values[r * kPitch + kSide - 1];
      if (c > 0 && c < kSide && c % smoothness != 0) value = patch.values[r * kPitch + c - 1];
    }
  }
  return patch;
}

PatchWeights randomWeights(std::uint64_t seed, double most = 1) {
  Random random(seed);
  PatchWeights weights = {};
  for (int r = 0; r < kInner; ++r) {
    for (int c = 0; c < kInner; ++c) weights.values[r * kPitch + c] = float(random.uniform(0, most));
  }
  return weights;
}

/// Bilinear interpolation with the weights that the kernel documents.
float sampled(const PatchGrid& g, int r, int c, bool clamped, bool& outside) {
  std::int32_t x = g.x + c * g.across_x + r * g.down_x, y = g.y + c * g.across_y + r * g.down_y;
  outside = false;
  if (clamped) {
    const std::int32_t px = std::clamp(x, 0, (g.width - 1) * 65536),
                       py = std::clamp(y, 0, (g.height - 1) * 65536);
    outside = px != x || py != y;
    x = px;
    y = py;
  }
  const int column = clamped ? std::min(x >> 16, g.width - 2) : x >> 16;
  const int row = clamped ? std::min(y >> 16, g.height - 2) : y >> 16;
  const int u = (x - column * 65536) >> 2, v = (y - row * 65536) >> 2;
  const std::int16_t* const p = g.pixels + row * g.stride + column;
  const int top = (p[0] * (16384 - u) + p[1] * u + 8192) >> 14;
  const int bottom = (p[g.stride] * (16384 - u) + p[g.stride + 1] * u + 8192) >> 14;
  return float(top * (16384 - v) + bottom * v) * (1.0F / (128 * 16384));
}

std::vector<PatchGrid> grids(const std::int16_t* pixels, bool clamped) {
  Random random(3);
  std::vector<PatchGrid> result;
  while (result.size() < 40) {
    const double reach = clamped ? 6 : 0.7;
    const auto step = [&] { return std::int32_t(random.uniform(-reach, reach) * 65536); };
    PatchGrid g{pixels, kStride, kWidth, kHeight, 0, 0, step(), step(), step(), step()};
    const auto place = [&](int size) { return std::int32_t(random.uniform(0, size - 1) * 65536); };
    g.x = place(kWidth) - 15 * (g.across_x + g.down_x);
    g.y = place(kHeight) - 15 * (g.across_y + g.down_y);
    bool inside = true;
    for (const int r : {0, kSide - 1}) {
      for (const int c : {0, kSide - 1}) {
        const std::int32_t x = g.x + c * g.across_x + r * g.down_x, y = g.y + c * g.across_y + r * g.down_y;
        inside = inside && x >= 0 && y >= 0 && x < (kWidth - 1) * 65536 && y < (kHeight - 1) * 65536;
      }
    }
    if (clamped || inside) result.push_back(g);
  }
  return result;
}

TEST_F(PatchKernelsTest, SamplesAreInterpolatedInWholeNumbers) {
  const std::vector<std::int16_t> pixels = randomPixels(1);
  for (const bool clamped : {false, true}) {
    for (const PatchGrid& grid : grids(pixels.data(), clamped)) {
      std::vector<float> expected;
      int expected_outside = 0;
      for (int r = 0; r < kSide; ++r) {
        for (int c = 0; c < kSide; ++c) {
          bool outside;
          expected.push_back(sampled(grid, r, c, clamped, outside));
          expected_outside += outside ? 1 : 0;
        }
      }
      atEveryLevel([&](const PatchKernels& k) {
        Patch patch;
        std::fill(std::begin(patch.values), std::end(patch.values), -1.0F);
        if (clamped) {
          EXPECT_EQ(k.sample_clamped(grid, patch), expected_outside);
        } else {
          k.sample(grid, patch);
        }
        for (int r = 0; r < kSide; ++r) {
          for (int c = 0; c < kPitch; ++c) {
            ASSERT_EQ(patch.values[r * kPitch + c], expected[std::size_t(r * kSide + std::min(c, kSide - 1))])
                << r << " " << c;
          }
        }
        for (int i = 0; i < Patch::kBeyond; ++i) EXPECT_EQ(patch.values[kSide * kPitch + i], 0);
      });
    }
  }
}

TEST_F(PatchKernelsTest, BlursRowsAndColumns) {
  const std::vector<float> half = {0.3F, 0.2F, 0.09F, 0.04F, 0.02F, 0.01F, 0.005F, 0.002F, 0.001F};
  const Patch start = randomPatch(5);
  for (const bool rows : {true, false}) {
    for (const int reach : {0, 1, 3, 8}) {
      Patch expected = start;
      for (int r = 0; r < kSide; ++r) {
        for (int c = 0; c < kPitch; ++c) {
          const auto at = [&](int k) {
            return rows ? start.values[r * kPitch + std::clamp(std::min(c, kSide - 1) + k, 0, kSide - 1)]
                        : start.values[std::clamp(r + k, 0, kSide - 1) * kPitch + c];
          };
          float sum = half[0] * at(0);
          for (int k = 1; k <= reach; ++k) sum += half[std::size_t(k)] * (at(-k) + at(k));
          expected.values[r * kPitch + c] = sum;
        }
      }
      atEveryLevel([&](const PatchKernels& k) {
        Patch patch = start;
        (rows ? k.blur_rows : k.blur_columns)(half.data(), reach, patch);
        for (int i = 0; i < kSide * kPitch; ++i) ASSERT_EQ(patch.values[i], expected.values[i]) << i;
      });
    }
  }
}

/// 16 lanes, as the kernels add them up.
struct LaneSum {
  float lanes[16] = {};
  float total() const {
    float q[4];
    for (int i = 0; i < 4; ++i) q[i] = (lanes[i] + lanes[8 + i]) + (lanes[4 + i] + lanes[12 + i]);
    return (q[0] + q[2]) + (q[1] + q[3]);
  }
};

struct Gradient {
  float dx, dy;
};

Gradient gradientAt(const Patch& patch, int r, int c) {
  const float* const p = patch.values + (r + 1) * kPitch + c + 1;
  return {p[1] - p[-1], p[kPitch] - p[-kPitch]};
}

/// Turns, as the kernels compute them.
float directionOf(const Gradient& g) {
  const float x = std::abs(g.dx), y = std::abs(g.dy);
  const float t = std::min(x, y) / (std::max(x, y) + 1e-12F), s = t * t;
  float turns = t * (0.15912117F + s * (-0.05185401F + s * (0.02476110F - 0.00705479F * s)));
  turns = y > x ? 0.25F - turns : turns;
  turns = g.dx < 0 ? 0.5F - turns : turns;
  return g.dy < 0 ? 1.0F - turns : turns;
}

float lengthOf(const Gradient& g) { return std::sqrt(g.dx * g.dx + g.dy * g.dy); }

float contrastOf(const Patch& patch) {
  const auto [low, high] = std::minmax_element(patch.values, patch.values + kSide * kPitch);
  return *high - *low;
}

TEST_F(PatchKernelsTest, MomentsAreSumsOfProducts) {
  const Patch patch = randomPatch(7);
  const PatchWeights window = randomWeights(8);
  LaneSum xx, xy, yy;
  double exact = 0;
  for (int r = 0; r < kInner; ++r) {
    for (int c = 0; c < kInner; ++c) {
      const Gradient g = gradientAt(patch, r, c);
      const float w = window.values[r * kPitch + c], wx = w * g.dx, wy = w * g.dy;
      xx.lanes[c % 16] += wx * g.dx;
      xy.lanes[c % 16] += wx * g.dy;
      yy.lanes[c % 16] += wy * g.dy;
      exact += double(w) * g.dx * g.dy;
    }
  }
  EXPECT_NEAR(xy.total(), exact, 1e-4 * xx.total());
  atEveryLevel([&](const PatchKernels& k) {
    const GradientMoments moments = k.moments(patch, window);
    EXPECT_EQ(moments.xx, xx.total());
    EXPECT_EQ(moments.xy, xy.total());
    EXPECT_EQ(moments.yy, yy.total());
  });
}

TEST_F(PatchKernelsTest, FiltersAreFoldedAboutTheMiddleRow) {
  const Patch patch = randomPatch(9);
  Random random(10);
  PatchFilters filters = {};
  for (auto& filter : filters.values) {
    for (auto& row : filter) {
      for (int c = 0; c < kSide; ++c) row[c] = float(random.uniform(-1, 1));
    }
  }
  for (int k = 0; k < PatchFilters::kCount; ++k) {
    LaneSum sum;
    double exact = 0;
    for (int r = 0; r <= Patch::kHalf; ++r) {
      for (int c = 0; c < kPitch; ++c) {
        const float above = patch.values[(Patch::kHalf - r) * kPitch + c];
        const float below = patch.values[(Patch::kHalf + r) * kPitch + c];
        sum.lanes[c % 16] += (r == 0 ? above : above + below) * filters.values[k][r][c];
        exact += (r == 0 ? double(above) : double(above) + below) * filters.values[k][r][c];
      }
    }
    EXPECT_NEAR(sum.total(), exact, 1);
    atEveryLevel([&](const PatchKernels& kernel) {
      float sums[PatchFilters::kCount];
      kernel.filter(patch, filters, sums);
      EXPECT_EQ(sums[k], sum.total());
    });
  }
}

TEST_F(PatchKernelsTest, UprightFiltersAreThoseOfASampledPatch) {
  const std::vector<std::int16_t> pixels = randomPixels(13);
  Random random(14);
  PatchFilters filters = {};
  for (auto& filter : filters.values) {
    for (auto& row : filter) {
      for (int c = 0; c < kSide; ++c) row[c] = float(random.uniform(-1, 1));
    }
  }
  for (const double step : {0.3, 1.0, 1.37, 1.9}) {
    PatchGrid grid{pixels.data(), kStride, kWidth, kHeight, 0, 0, 0, 0, 0, 0};
    grid.across_x = grid.down_y = std::int32_t(step * 65536);
    grid.x = std::int32_t(5.3 * 65536);
    grid.y = std::int32_t(7.7 * 65536);
    Patch patch;
    float expected[PatchFilters::kCount], first[PatchFilters::kCount];
    kernels().patches.sample(grid, patch);
    kernels().patches.filter(patch, filters, expected);
    kernels().patches.filter_upright(grid, filters, first);
    atEveryLevel([&](const PatchKernels& k) {
      float sums[PatchFilters::kCount];
      k.filter_upright(grid, filters, sums);
      for (int i = 0; i < PatchFilters::kCount; ++i) {
        // Samples are rounded to 2^-7 grey levels at other places, which nearly cancels out.
        EXPECT_NEAR(sums[i], expected[i], 1);
        EXPECT_EQ(sums[i], first[i]);
      }
    });
  }
}

TEST_F(PatchKernelsTest, ResponsesAreDeterminantsOfTheHessian) {
  const std::vector<std::int16_t> pixels = randomPixels(11);
  const auto at = [&](int y, int x) { return float(pixels[std::size_t(y * kStride + x)]); };
  for (const int width : {3, 5, 12, kWidth}) {
    for (const int y : {1, 7, kHeight - 2}) {
      std::vector<float> expected(std::size_t(width), -7.0F);
      for (int x = 1; x < width - 1; ++x) {
        const float xx = at(y, x - 1) + at(y, x + 1) - 2 * at(y, x),
                    yy = at(y - 1, x) + at(y + 1, x) - 2 * at(y, x);
        const float xy =
            0.25F * ((at(y - 1, x - 1) + at(y + 1, x + 1)) - (at(y - 1, x + 1) + at(y + 1, x - 1)));
        expected[std::size_t(x)] = 1e-3F * (xx * yy - xy * xy);
      }
      atEveryLevel([&](const PatchKernels&) {
        std::vector<float> out(std::size_t(width), -7.0F);
        const std::int16_t* const row = pixels.data() + std::ptrdiff_t{y} * kStride;
        kernels().hessian.responses(row - kStride, row, row + kStride, width, 1e-3F, out.data());
        EXPECT_EQ(out, expected);
      });
    }
  }
}

TEST_F(PatchKernelsTest, ExtremaExceedTheirNeighbours) {
  Random random(12);
  for (const int levels : {3, 40, 100000}) {  // few levels: many equal values
    std::vector<std::vector<float>> rows(3, std::vector<float>(kWidth));
    for (std::vector<float>& row : rows) {
      for (float& value : row) value = float(std::floor(random.uniform(-levels, levels + 1)) / levels);
    }
    std::vector<std::int32_t> expected;
    for (int x = 2; x < kWidth - 1; ++x) {
      const float v = rows[1][std::size_t(x)];
      bool largest = v >= 0.4F, smallest = v <= -0.4F;
      for (int i = 0; i < 9; ++i) {
        if (i == 4) continue;
        const float other = rows[std::size_t(i / 3)][std::size_t(x + i % 3 - 1)];
        largest = largest && v > other;
        smallest = smallest && v < other;
      }
      if (largest || smallest) expected.push_back(x);
    }
    EXPECT_FALSE(levels > 3 && expected.empty());
    atEveryLevel([&](const PatchKernels&) {
      const float* const three[3] = {rows[0].data(), rows[1].data(), rows[2].data()};
      std::vector<std::int32_t> columns(kWidth);
      const int n = kernels().hessian.extrema(three, 2, kWidth - 1, 0.4F, columns.data());
      columns.resize(std::size_t(n));
      EXPECT_EQ(columns, expected);
    });
  }
}

TEST_F(PatchKernelsTest, DirectionsAreWithinTheirBounds) {
  // The polynomial against the arc tangent, through a patch that has one gradient.
  for (int degrees = 0; degrees < 360; ++degrees) {
    const double angle = degrees * CV_PI / 180;
    const Gradient g{float(20 * std::cos(angle)), float(20 * std::sin(angle))};
    const double difference = std::abs(double(directionOf(g)) - degrees / 360.0);
    EXPECT_LT(std::min(difference, 1 - difference), 3e-5) << degrees;
  }
  PatchWeights window = {};
  for (int i = 0; i < kInner; ++i) {
    for (int j = 0; j < kInner; ++j) window.values[i * kPitch + j] = 0.3F;
  }
  for (int degrees = 0; degrees < 360; degrees += 7) {
    const double angle = degrees * CV_PI / 180;
    Patch patch = {};
    for (int i = 0; i < kSide * kPitch; ++i) {
      const int c = std::min(i % kPitch, kSide - 1);
      patch.values[i] = float(100 + std::cos(angle) * c + std::sin(angle) * (i / kPitch));
    }
    atEveryLevel([&](const PatchKernels& k) {
      DirectionCounts counts;
      k.directions(patch, window, counts);
      double along_x = 0, along_y = 0;
      for (int bin = 0; bin < DirectionCounts::kBins; ++bin) {
        along_x += double(counts.bins[bin]) * std::cos(bin * CV_PI / 18);
        along_y += double(counts.bins[bin]) * std::sin(bin * CV_PI / 18);
      }
      EXPECT_NEAR(std::remainder(std::atan2(along_y, along_x) - angle, 2 * CV_PI), 0, 1e-3) << degrees;
    });
  }
}

TEST_F(PatchKernelsTest, DirectionsAreCountedInWholeNumbers) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Patch patch = randomPatch(seed, int(seed));
    const PatchWeights window = randomWeights(seed, 0.6);
    const float unit = 2896.0F / contrastOf(patch);
    std::vector<std::int64_t> bins(DirectionCounts::kBins);
    for (int r = 0; r < kInner; r += 2) {
      for (int c = 0; c < kInner; ++c) {
        const Gradient g = gradientAt(patch, r, c);
        const auto length = int(lengthOf(g) * (unit * window.values[r * kPitch + c]) + 0.5F);
        const auto turns = int(directionOf(g) * 65536.0F + 0.5F);
        for (int bin = 0; bin < DirectionCounts::kBins; ++bin) {
          const int distance = std::abs(int(std::int16_t(turns - (bin * 65536 + 18) / 36)));
          bins[std::size_t(bin)] += std::int64_t{length} * std::max(0, 65536 / 36 - distance);
        }
      }
    }
    atEveryLevel([&](const PatchKernels& k) {
      DirectionCounts counts;
      k.directions(patch, window, counts);
      for (int bin = 0; bin < DirectionCounts::kBins; ++bin) {
        ASSERT_EQ(counts.bins[bin], float(bins[std::size_t(bin)])) << bin;
      }
    });
  }
}

CellTables randomTables(std::uint64_t seed) {
  Random random(seed);
  CellTables tables = {};
  for (int r = 1; r <= kInner; ++r) {
    for (int c = 0; c < kInner; ++c) {
      const double weight = random.uniform(0.1, 1), share = r % 6 / 6.0;
      tables.rows[r][0][c] = float((1 - share) * weight);
      tables.rows[r][1][c] = float(share * weight);
    }
  }
  for (int cell = 0; cell < CellTables::kCells; ++cell) {
    for (int c = std::max(0, 6 * cell - 1); c <= std::min(kInner - 1, 6 * cell + 10); ++c) {
      tables.columns[cell][c] = float(random.uniform(0, 1));
    }
  }
  return tables;
}

std::vector<float> plainDescriptor(const Patch& patch, const CellTables& tables) {
  constexpr int kCells = CellTables::kCells, kDirections = CellTables::kDirections;
  const float unit = 23160.0F / contrastOf(patch);
  std::vector<std::int64_t> sums(std::size_t{kCells} * kDirections * kPitch);
  for (int r = 1; r <= kInner; ++r) {
    for (int c = 0; c < kPitch; ++c) {
      const Gradient g = gradientAt(patch, r - 1, c);
      const auto turns = int(directionOf(g) * 65536.0F + 0.5F);
      for (int side = 0; side < 2; ++side) {
        const int cell = r / 6 - 1 + side;
        if (cell < 0 || cell >= kCells) continue;
        const auto length = int(unit * lengthOf(g) * tables.rows[r][side][c] + 0.5F);
        for (int k = 0; k < kDirections; ++k) {
          const int d = std::abs(int(std::int16_t(turns - 8192 * k)));
          sums[std::size_t((cell * kDirections + k) * kPitch + c)] +=
              std::int64_t{length} * std::max(0, 8192 - d);
        }
      }
    }
  }
  std::vector<float> values;
  for (int row = 0; row < kCells; ++row) {
    for (int cell = 0; cell < kCells; ++cell) {
      for (int k = 0; k < kDirections; ++k) {
        LaneSum sum;
        for (int c = 0; c < kPitch; ++c) {
          const std::int64_t of_column = sums[std::size_t((row * kDirections + k) * kPitch + c)];
          EXPECT_LT(of_column, std::int64_t{1} << 31);
          sum.lanes[c % 16] += float(of_column) * tables.columns[cell][c];
        }
        values.push_back(sum.total());
      }
    }
  }
  const auto length = [&] {
    LaneSum sum;
    for (std::size_t i = 0; i < values.size(); ++i) sum.lanes[i % 16] += values[i] * values[i];
    return std::sqrt(sum.total());
  };
  const float limit = 0.2F * length();
  for (float& value : values) value = std::min(value, limit);
  const float factor = 512 / length();
  for (float& value : values) value = std::min(255.0F, float(int(value * factor + 0.5F)));
  return values;
}

TEST_F(PatchKernelsTest, DescriptorsAreThoseOfAPlainLoop) {
  for (int seed = 1; seed <= 20; ++seed) {
    Patch patch = randomPatch(std::uint64_t(seed), seed);
    if (seed == 20) {  // the longest gradients
      for (int i = 0; i < kSide * kPitch; ++i)
        patch.values[i] = i / kPitch % 4 < 2 && i % 4 < 2 ? 0.0F : 255.0F;
    }
    const CellTables tables = randomTables(std::uint64_t(seed));
    const std::vector<float> expected = plainDescriptor(patch, tables);
    atEveryLevel([&](const PatchKernels& k) {
      std::vector<float> descriptor(CellTables::kLength, -1.0F);
      ASSERT_TRUE(k.describe(patch, tables, descriptor.data()));
      EXPECT_EQ(descriptor, expected);
    });
  }
}

TEST_F(PatchKernelsTest, AFlatPatchHasNoDescriptor) {
  Patch patch = {};
  std::fill_n(patch.values, kSide * kPitch, 17.0F);
  const CellTables tables = randomTables(1);
  const PatchWeights window = randomWeights(1);
  atEveryLevel([&](const PatchKernels& k) {
    float descriptor[CellTables::kLength];
    EXPECT_FALSE(k.describe(patch, tables, descriptor));
    DirectionCounts counts;
    k.directions(patch, window, counts);
    for (const float bin : counts.bins) EXPECT_EQ(bin, 0);
  });
}

}  // namespace
}  // namespace corrsel::core
