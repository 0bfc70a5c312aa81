#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Bytes that the kernels of this header may read behind the last byte that they need, and write behind the
/// last one of a row of scores.
inline constexpr int kCornerPadding = 64;

/// A pixel.
struct PixelPlace {
  std::int32_t x, y;
};

/// Sums over a block of 7 x 7 px of products of derivatives by Sobel's operator; all are below 2^26.
struct StructureSums {
  std::int32_t xx, yy, xy;
};

/// The loops of FAST and of Harris' corner measure.
struct CornerKernels {
  /// FAST 9-16 (Rosten and Drummond, ECCV 2006) for a row of pixels. The score of a pixel is the largest s
  /// such that nine contiguous pixels of its circle of 16 are all brighter, or all darker, by at least s. A
  /// score that is not above the threshold becomes 0.
  /// @param row  first pixel; three rows above and below and three pixels left and right of it are read
  /// @return whether any of the n scores is above the threshold; those behind the n-th may count as well
  bool (*scores)(const std::uint8_t* row, std::ptrdiff_t stride, int n, int threshold, std::uint8_t* scores);

  /// The columns whose score is above 0, above the four neighbours before it (row by row) and not below the
  /// four after it, so of equal neighbours the first one counts.
  /// @param above, here, below  scores of three rows; one more is read left of them
  /// @return the number of columns written, at most n
  int (*maxima)(const std::uint8_t* above, const std::uint8_t* here, const std::uint8_t* below, int n,
                std::int32_t* columns);

  /// The sums of the block around every place. @pre the places are at least 4 px from the border, and 8 more
  /// bytes may be read behind a row
  void (*structure)(const std::uint8_t* pixels, std::ptrdiff_t stride, const PixelPlace* places,
                    std::size_t n, StructureSums* sums);
};

}  // namespace corrsel::core
