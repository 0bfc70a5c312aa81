#pragma once

#include <cstdint>

namespace corrsel::core {

/// A column, and a level from 1 on.
struct ExtremumPlace {
  std::int32_t column, level;
};

/// Rows of an image in 16 bits are filtered, compared and searched for extrema in whole numbers, so the
/// results are exact and independent of the order of the operations.
///
/// Weights are whole numbers whose sum is 2^15 for every filter. They come in pairs for two neighbouring rows
/// or columns: the first weight is in the lower 16 bits, the second one in the upper 16 bits. A filtered
/// value is (sum + 2^14) >> 15. Pixels are not negative.
///
/// Rows have `kRowSlack` pixels behind the last one that may be read, and written where a row is an output.
struct ScaleSpaceKernels {
  static constexpr int kRowSlack = 32;

  /// Two filters over the same rows, column by column: first[x] = sum over k of w1[k] rows[k][x], and
  /// second[x] with w2.
  /// @param rows  2 * pairs rows
  /// @param first_weights, second_weights  `pairs` pairs each
  void (*filterColumns)(const std::int16_t* const* rows, const std::int32_t* first_weights,
                        const std::int32_t* second_weights, int pairs, int n, std::int16_t* first,
                        std::int16_t* second);

  /// out[x] = sum over k of w[k] in[x + k].
  /// @param in  n + 2 * pairs - 1 pixels and the slack
  void (*filterRow)(const std::int16_t* in, const std::int32_t* weights, int pairs, int n, std::int16_t* out);

  /// Two filters that double the number of pixels: out[2 x] with w1 and out[2 x + 1] with w2, both over in[x
  /// + k]. The output has twice the slack.
  void (*doubleRow)(const std::int16_t* in, const std::int32_t* first_weights,
                    const std::int32_t* second_weights, int pairs, int n, std::int16_t* out);

  /// out[x] = b[x] - a[x].
  void (*subtractRows)(const std::int16_t* a, const std::int16_t* b, int n, std::int16_t* out);

  /// The places in one row, in columns [begin, end), where the differences of a level are extremal: the
  /// absolute value exceeds the threshold, and it is the largest of its 27 neighbours where it is positive,
  /// the smallest where it is negative. Of neighbours that are equal, the first in the order of levels, rows
  /// and columns counts.
  /// @param rows     the rows before, at and after this row, of each of levels + 2 levels, in this order;
  /// with a pixel on each side of [begin, end)
  /// @param levels   that are searched: all but the first and the last of the given ones; 1 to kMaxLevels
  /// @param found    receives the places in an arbitrary order; up to levels * (end - begin)
  /// @return their number
  int (*extrema)(const std::int16_t* const* rows, int levels, int begin, int end, std::int16_t threshold,
                 ExtremumPlace* found);

  static constexpr int kMaxLevels = 10;
};

}  // namespace corrsel::core
