#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// The columns of an image that is reduced by bilinear interpolation, in groups of eight. Column i of a group
/// is (weights[2 i] p + weights[2 i + 1] q) / 64, with the pixels p and q at first + places[2 i] and first +
/// places[2 i + 1] of the row.
struct ShrinkColumns {
  static constexpr int kGroup = 8;
  static constexpr int kReach = 16;    ///< all places of a group are below this if `narrow`
  static constexpr int kPadding = 64;  ///< bytes that may be read behind a row, and columns written

  const std::int32_t* first;    ///< per group
  const std::uint8_t* places;   ///< 16 per group
  const std::uint8_t* weights;  ///< 16 per group
  int groups;                   ///< even
  bool narrow;
};

/// The loops over pixels of an image pyramid.
struct ShrinkKernels {
  /// Interpolates in a row. @param out  64 times the grey level, kGroup columns per group
  void (*columns)(const std::uint8_t* row, const ShrinkColumns& columns, std::int16_t* out);

  /// Interpolates between two rows of columns(): (top + (bottom - top) weight / 2^15) / 64, rounded.
  /// @param weight  0 to 2^15 - 1
  void (*rows)(const std::int16_t* top, const std::int16_t* bottom, std::int16_t weight, int n,
               std::uint8_t* out);

  /// Binomial-like blur with 7 taps, which is a Gaussian with a sigma of 2: seven rows are added with weights
  /// that sum up to 128.
  void (*blur_rows)(const std::uint8_t* first, std::ptrdiff_t stride, int n, std::uint16_t* out);

  /// The same of the columns of blur_rows(), back to grey levels.
  /// @param sums  three columns left of the first one of the result
  void (*blur_columns)(const std::uint16_t* sums, int n, std::uint8_t* out);
};

}  // namespace corrsel::core
