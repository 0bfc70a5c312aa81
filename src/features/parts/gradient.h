#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace corrsel::core {

/// The arc tangent of small / large, where 0 <= small <= large, in turns, i.e. from 0 to 1/8. The error is
/// below 2e-6 turns.
///
/// Source: Hastings, Approximations for Digital Computers, 1955, sheet 11.
struct FineArctangent {
  static float turns(float small, float large) {
    constexpr float kTurns = 0.15915494309F;
    const float t = small / std::max(large, 1e-30F), s = t * t;
    return kTurns * t *
           (0.99997726F + s * (-0.33262347F +
                               s * (0.19354346F + s * (-0.11643287F + s * (0.05265332F - s * 0.01172120F)))));
  }
};

/// As FineArctangent, with two terms less: the error is below 3e-5 turns (0.01 degrees). It serves where
/// every pixel around thousands of keypoints needs a direction.
struct FastArctangent {
  static float turns(float small, float large) {
    const float t = small / (large + 1e-12F), s = t * t;
    return t * (0.15912117F + s * (-0.05185401F + s * (0.02476110F - 0.00705479F * s)));
  }
};

/// The direction of a gradient in turns, from 0 to 1 inclusive, counted from +x to +y. The polynomial for the
/// first octant is mirrored into the others.
template <class Arctangent>
inline float directionOf(float dx, float dy) {
  const float x = std::abs(dx), y = std::abs(dy);
  float angle = Arctangent::turns(std::min(x, y), std::max(x, y));
  angle = y > x ? 0.25F - angle : angle;
  angle = dx < 0 ? 0.5F - angle : angle;
  return dy < 0 ? 1.0F - angle : angle;
}

/// Length and direction of n gradients; the direction is in [0, turn), counted from +x to +y.
/// @param turn  value of a full turn, e.g. 2 pi or the number of histogram bins. Error below 2e-6 turns.
void polarGradients(const float* dx, const float* dy, std::size_t n, float turn, float* length,
                    float* direction);

/// Gradients of the inner samples of a square patch, by central differences (not halved). Row-major arrays.
/// @tparam kSide  samples along a side of the patch
template <int kSide>
struct PatchGradients {
  static constexpr std::size_t kInner = kSide - 2;  ///< samples along a side that have a gradient
  static constexpr std::size_t kCount = kInner * kInner;

  std::array<float, kCount> dx, dy, length, direction;

  /// @param patch  kSide^2 samples
  /// @param turn  as in polarGradients()
  void compute(const float* patch, float turn) {
    for (std::size_t r = 0; r < kInner; ++r) {
      const float* const row = patch + (r + 1) * kSide + 1;
      for (std::size_t c = 0; c < kInner; ++c) {
        dx[r * kInner + c] = row[c + 1] - row[static_cast<std::ptrdiff_t>(c) - 1];
        dy[r * kInner + c] = row[c + kSide] - row[static_cast<std::ptrdiff_t>(c) - kSide];
      }
    }
    polarGradients(dx.data(), dy.data(), kCount, turn, length.data(), direction.data());
  }
};

}  // namespace corrsel::core
