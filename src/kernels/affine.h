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

/// Matches with the rotation and the scale of their local maps. The columns can be read up to kMultiple slots
/// behind their ends.
struct FramedMatches {
  const float *left_x, *left_y, *right_x, *right_y;
  const float *cosine, *sine, *scale;  ///< the scale as a logarithm; NaN where there is no map

  static constexpr std::size_t kMultiple = 16;
};

/// A match, and how much its neighbours may differ from it.
struct FramedReach {
  float left_x, left_y, right_x, right_y, cosine, sine, scale;
  float squared_left, squared_right;  ///< distances below which points are near, squared
  float min_cosine, max_scale;        ///< of the differences of rotations and scales
};

/// The loops of affine verification.
struct AffineKernels {
  /// The number of matches whose squared error |A (left) - right|^2 is at most `squared_limit`. O(slots).
  /// @param a  row-major linear map
  std::int32_t (*count)(const RelativeMatches& matches, const float* a, float squared_limit);

  /// Writes the numbers from `begin` to `end` - 1 of the matches that are near in both images, and whose
  /// rotation and scale are similar. `numbers` has room for kMultiple more.
  /// @return how many were written. O(end - begin).
  std::size_t (*around)(const FramedMatches& matches, std::uint32_t begin, std::uint32_t end,
                        const FramedReach& reach, std::uint32_t* numbers);
};

}  // namespace corrsel::core
