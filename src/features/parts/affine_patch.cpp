#include "features/parts/affine_patch.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {
namespace {

/// Samples that are computed at once: longer rows are split.
constexpr int kRow = 64;

constexpr float kUnit = 1.0F / kGreyUnit;

/// Interpolates bilinearly at n positions, from pairs of neighbours in the upper and the lower row.
void blend(const float* upper, const float* lower, const float* wx, const float* wy, std::ptrdiff_t n,
           float* out) {
  for (std::ptrdiff_t i = 0; i < n; ++i) {
    const float top = upper[2 * i] + wx[i] * (upper[2 * i + 1] - upper[2 * i]);
    const float bottom = lower[2 * i] + wx[i] * (lower[2 * i + 1] - lower[2 * i]);
    out[i] = top + wy[i] * (bottom - top);
  }
}

}  // namespace

const ScaleLevel& levelFor(const std::vector<ScaleLevel>& levels, double sigma) {
  const auto next =
      std::upper_bound(levels.begin() + 1, levels.end(), sigma,
                       [](double value, const ScaleLevel& level) { return value < level.sigma; });
  return *(next - 1);
}

HalfAxes halfAxes(const AffineFrame& a) {
  const double sum = std::hypot(double{a[0]} + a[4], double{a[3]} - a[1]) / 2;
  const double difference = std::hypot(double{a[0]} - a[4], double{a[3]} + a[1]) / 2;
  return {std::abs(sum - difference), sum + difference};
}

std::size_t samplePatch(const ScaleLevel& level, const AffineFrame& frame, int half, double spacing,
                        float* patch) {
  const double scale = spacing / level.step;
  const double a11 = frame[0] * scale, a12 = frame[1] * scale, a21 = frame[3] * scale, a22 = frame[4] * scale;
  const double x = (frame[2] - level.offset) / level.step, y = (frame[5] - level.offset) / level.step;
  const double reach_x = half * (std::abs(a11) + std::abs(a12)),
               reach_y = half * (std::abs(a21) + std::abs(a22));
  const int side = 2 * half + 1;
  const bool inside =
      x - reach_x >= 1 && y - reach_y >= 1 && x + reach_x < level.width - 2 && y + reach_y < level.height - 2;
  // Positions are relative to a pixel nearby. They are therefore small and positive, so single precision is
  // exact enough and truncation rounds down.
  const int origin_x = inside ? static_cast<int>(x - reach_x) - 1 : 0;
  const int origin_y = inside ? static_cast<int>(y - reach_y) - 1 : 0;
  const std::int16_t* const pixels = level.pixels + origin_y * level.stride + origin_x;
  const auto step_x = static_cast<float>(a11), step_y = static_cast<float>(a21);
  const auto last_x = static_cast<float>(level.width - 1), last_y = static_cast<float>(level.height - 1);
  const int last_column = level.width - 2 - origin_x, last_row = level.height - 2 - origin_y;
  int outside = 0;
  float px[kRow], py[kRow], wx[kRow], wy[kRow], upper[2 * kRow], lower[2 * kRow];
  std::ptrdiff_t offset[kRow];
  for (int r = -half; r <= half; ++r) {
    for (int from = 0; from < side; from += kRow) {
      const int n = std::min(kRow, side - from);
      const auto start_x = static_cast<float>(x - origin_x + r * a12 + (from - half) * a11);
      const auto start_y = static_cast<float>(y - origin_y + r * a22 + (from - half) * a21);
      for (int i = 0; i < n; ++i) {
        px[i] = start_x + step_x * static_cast<float>(i);
        py[i] = start_y + step_y * static_cast<float>(i);
      }
      if (!inside) {
        for (int i = 0; i < n; ++i) {
          // The order of the arguments matters: a position that is NaN becomes 0.
          const float cx = std::min(last_x, std::max(0.0F, px[i]));
          const float cy = std::min(last_y, std::max(0.0F, py[i]));
          outside += cx == px[i] && cy == py[i] ? 0 : 1;
          px[i] = cx;
          py[i] = cy;
        }
      }
      for (int i = 0; i < n; ++i) {
        // In the last column and row the pixel before has the weight 0.
        const int column = std::min(static_cast<int>(px[i]), last_column);
        const int row = std::min(static_cast<int>(py[i]), last_row);
        wx[i] = px[i] - static_cast<float>(column);
        wy[i] = py[i] - static_cast<float>(row);
        offset[i] = row * level.stride + column;
      }
      for (int i = 0; i < n; ++i) {
        const std::int16_t* const p = pixels + offset[i];
        for (int k = 0; k < 2; ++k) {
          upper[2 * i + k] = kUnit * static_cast<float>(p[k]);
          lower[2 * i + k] = kUnit * static_cast<float>(p[level.stride + k]);
        }
      }
      blend(upper, lower, wx, wy, n, patch);
      patch += n;
    }
  }
  return static_cast<std::size_t>(outside);
}

std::vector<float> gaussianWindow(int half, double spacing, double sigma) {
  std::vector<float> weights;
  for (int r = -half; r <= half; ++r) {
    for (int c = -half; c <= half; ++c) {
      const double distance2 = spacing * spacing * (r * r + c * c);
      weights.push_back(static_cast<float>(std::exp(-distance2 / (2 * sigma * sigma))));
    }
  }
  return weights;
}

}  // namespace corrsel::core
