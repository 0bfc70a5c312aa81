#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Sampling of an image along lines in any direction.
struct ViewKernels {
  static constexpr int kSlack = 16;  ///< pixels behind the last one that may be written

  /// out[k] = 128 times the image at (x + k dx, y + k dy), interpolated bilinearly.
  /// @param quads   the pixels around every place, 8 bits each: (0, 0) in the lowest bits, then (1, 0), (0,
  /// 1) and (1, 1)
  /// @param stride  from one row of quads to the next
  /// @param x, y, dx, dy  in units of 2^-16 px, relative to the pixel that `quads` points to; all places are
  /// in the image, and less than 32768 px away
  /// @param n  at least 1
  void (*sampleLine)(const std::uint32_t* quads, std::ptrdiff_t stride, std::int32_t x, std::int32_t y,
                     std::int32_t dx, std::int32_t dy, int n, std::int16_t* out);
};

}  // namespace corrsel::core
