#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Histograms of gradient directions in a window of a level in 16 bits.
struct OrientationKernels {
  static constexpr int kBins = 36;
  static constexpr int kLanes = 16;  ///< windows are processed in groups of so many columns

  /// Adds up the lengths of the gradients (central differences, not halved), weighted by across[column] *
  /// down[row], by direction: bin k is the direction k / 36 of a turn, counted from +x to +y.
  /// @param window   the first pixel of the window; its neighbours on all sides are pixels too, and so many
  /// pixels as `columns` rounded up to kLanes may be read in every row
  /// @param across   `columns` weights, and zeros up to the next multiple of kLanes
  /// @param bins     receives kBins sums
  void (*histogram)(const std::int16_t* window, std::ptrdiff_t stride, int columns, int rows,
                    const float* across, const float* down, float* bins);
};

}  // namespace corrsel::core
