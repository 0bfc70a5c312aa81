#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Points of matches relative to one match, in both images. The slots behind the last match hold points that
/// no map predicts.
struct RelativeMatches {
  const float *left_x, *left_y, *right_x, *right_y;
  std::size_t slots;  ///< a multiple of kMultiple

  static constexpr std::size_t kMultiple = 16;
};

/// The loop of affine verification.
struct AffineKernels {
  /// The number of matches whose squared error |A (left) - right|^2 is at most `squared_limit`. O(slots).
  /// @param a  row-major linear map
  std::int32_t (*count)(const RelativeMatches& matches, const float* a, float squared_limit);
};

}  // namespace corrsel::core
