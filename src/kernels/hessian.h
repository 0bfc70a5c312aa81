#pragma once

#include <cstdint>

namespace corrsel::core {

/// The loops over a level of a scale space in which the determinant of the Hessian is extremal.
struct HessianKernels {
  /// out[x] = factor * (xx yy - xy^2) for x from 1 to width - 2, where xx, yy and xy are second differences
  /// of the pixels at x: p(-1) - 2 p(0) + p(1) along a row or column, and a quarter of the mixed difference.
  void (*responses)(const std::int16_t* above, const std::int16_t* row, const std::int16_t* below, int width,
                    float factor, float* out);

  /// The columns in [begin, end) where the middle row has a local extremum: a value of at least `threshold`
  /// that exceeds its eight neighbours, or one of at most -threshold that is below them.
  /// @param rows     three rows, whose columns from begin - 1 to end are read
  /// @param columns  receives the columns in ascending order; room for end - begin
  /// @return the number of columns
  int (*extrema)(const float* const* rows, int begin, int end, float threshold, std::int32_t* columns);
};

}  // namespace corrsel::core
