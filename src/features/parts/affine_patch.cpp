#include "features/parts/affine_patch.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace corrsel::core {
namespace {

/// Longest row of a patch that is sampled in one go.
constexpr int kRow = 64;

/// Blends the four pixels around each of n positions: pairs of neighbours in the upper and lower row.
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
  const double x = frame[2] / level.step, y = frame[5] / level.step;
  const double reach_x = half * (std::abs(a11) + std::abs(a12)),
               reach_y = half * (std::abs(a21) + std::abs(a22));
  const int side = 2 * half + 1;
  const bool inside =
      x - reach_x >= 1 && y - reach_y >= 1 && x + reach_x < level.width - 2 && y + reach_y < level.height - 2;
  // Counted from a whole pixel nearby: positions stay small and positive, hence exact enough in single
  // precision, and truncation rounds down.
  const int origin_x = inside ? static_cast<int>(x - reach_x) - 1 : 0;
  const int origin_y = inside ? static_cast<int>(y - reach_y) - 1 : 0;
  const float* const pixels = level.pixels + static_cast<std::ptrdiff_t>(origin_y) * level.width + origin_x;
  const auto step_x = static_cast<float>(a11), step_y = static_cast<float>(a21);
  const auto last_x = static_cast<float>(level.width - 1), last_y = static_cast<float>(level.height - 1);
  const int last_column = level.width - 2 - origin_x, last_row = level.height - 2 - origin_y;
  int outside = 0;
  float px[kRow], py[kRow], wx[kRow], wy[kRow], upper[2 * kRow], lower[2 * kRow];
  int offset[kRow];
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
          // In this order 0 comes out of a position that is not a number.
          const float cx = std::min(last_x, std::max(0.0F, px[i]));
          const float cy = std::min(last_y, std::max(0.0F, py[i]));
          outside += cx == px[i] && cy == py[i] ? 0 : 1;
          px[i] = cx;
          py[i] = cy;
        }
      }
      for (int i = 0; i < n; ++i) {
        // In the last column and row the weight of the pixel before is 0.
        const int column = std::min(static_cast<int>(px[i]), last_column);
        const int row = std::min(static_cast<int>(py[i]), last_row);
        wx[i] = px[i] - static_cast<float>(column);
        wy[i] = py[i] - static_cast<float>(row);
        offset[i] = row * level.width + column;
      }
      for (int i = 0; i < n; ++i) {
        const float* const p = pixels + offset[i];
        std::memcpy(upper + std::ptrdiff_t{2} * i, p, 2 * sizeof(float));
        std::memcpy(lower + std::ptrdiff_t{2} * i, p + level.width, 2 * sizeof(float));
      }
      blend(upper, lower, wx, wy, n, patch);
      patch += n;
    }
  }
  return static_cast<std::size_t>(outside);
}

void polarGradients(const float* dx, const float* dy, std::size_t n, float turn, float* length,
                    float* direction) {
  // The arc tangent on [0, 1] as an odd polynomial (Hastings, Approximations for Digital Computers, 1955,
  // sheet 11), here in turns, then mirrored into the other octants.
  constexpr float kTurns = 0.15915494309F;
  for (std::size_t i = 0; i < n; ++i) {
    const float x = std::abs(dx[i]), y = std::abs(dy[i]);
    length[i] = std::sqrt(x * x + y * y);
    const float large = std::max(x, y), small = std::min(x, y);
    const float t = small / std::max(large, 1e-30F), s = t * t;
    float angle =
        kTurns * t *
        (0.99997726F +
         s * (-0.33262347F + s * (0.19354346F + s * (-0.11643287F + s * (0.05265332F - s * 0.01172120F)))));
    angle = y > x ? 0.25F - angle : angle;
    angle = dx[i] < 0 ? 0.5F - angle : angle;
    angle = dy[i] < 0 ? 1.0F - angle : angle;
    direction[i] = (angle >= 1.0F ? 0.0F : angle) * turn;
  }
}

}  // namespace corrsel::core
