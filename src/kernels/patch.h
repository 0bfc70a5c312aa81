#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// A square patch of kSide x kSide samples, row-major, with kPitch values from one row to the next. The last
/// column is repeated up to the pitch. All steps for one feature work on patches of this size.
struct Patch {
  static constexpr int kHalf = 15;             ///< samples on each side of the centre
  static constexpr int kSide = 2 * kHalf + 1;  ///< samples along a side
  static constexpr int kPitch = 32;
  static constexpr int kInner = kSide - 2;  ///< samples along a side that have a gradient

  static constexpr int kBeyond = 16;  ///< values after the last row, which are read but not used: zeros

  float values[kSide * kPitch + kBeyond];  ///< grey levels
};

/// A factor for the gradient of every inner sample of a patch, in the rows and columns of the gradients. The
/// columns from kInner on have the factor 0.
struct PatchWeights {
  float values[Patch::kInner * Patch::kPitch];
};

/// The places of samples on an image of 16-bit pixels. Sample (row r, column c) lies at (x + c across_x + r
/// down_x, y + c across_y + r down_y). Places are in units of 2^-16 px from the pixel that `pixels` points
/// to, so they are exact sums.
struct PatchGrid {
  /// Widths, heights, strides and all places are smaller than this, px.
  static constexpr int kMax = 32000;

  const std::int16_t* pixels;  ///< 0 to 32640, 128 times the grey level
  std::ptrdiff_t stride;       ///< pixels from one row to the next
  int width, height;           ///< px, at least 2; only used where places may lie outside
  std::int32_t x, y, across_x, across_y, down_x, down_y;
};

/// Constants of the descriptor.
struct CellTables {
  static constexpr int kCells = 4, kDirections = 8, kLength = kCells * kCells * kDirections;
  static constexpr int kCellSamples = 6;  ///< samples along one side of a cell

  /// Window times the shares of the cells before and after a row. Row r is that of the gradients of row r -
  /// 1, so that bands of kCellSamples rows have the same two cells; row 0 has the weights 0.
  float rows[Patch::kInner + 1][2][Patch::kPitch];

  /// The share of every column in each cell.
  float columns[kCells][Patch::kPitch];
};

/// Filters of the size of a patch that are symmetric about the middle row: one row of weights for the middle
/// row and for every pair of rows at the same distance from it. Columns from kSide on have the weight 0.
struct PatchFilters {
  static constexpr int kCount = 10;
  float values[kCount][Patch::kHalf + 1][Patch::kPitch];
};

/// Sums of the products of two components of the gradients.
struct GradientMoments {
  float xx, xy, yy;
};

/// A histogram of gradient directions.
struct DirectionCounts {
  static constexpr int kBins = 36;
  float bins[kBins];  ///< in an arbitrary unit
};

/// The loops over a patch around a feature.
struct PatchKernels {
  /// Samples bilinearly; weights have 14 bits. All places lie in [0, width - 1) x [0, height - 1) of
  /// `pixels`.
  void (*sample)(const PatchGrid& grid, Patch& patch);

  /// As sample(), but beyond the border the nearest pixel is used. Returns the number of samples beyond it.
  int (*sample_clamped)(const PatchGrid& grid, Patch& patch);

  /// Blurs along the rows or along the columns with a symmetric filter. Samples beyond the border equal the
  /// nearest sample.
  /// @param half   the weights of the middle and of the neighbours at the distances 1 to reach
  /// @param reach  0 to kMaxReach
  void (*blur_rows)(const float* half, int reach, Patch& patch);
  void (*blur_columns)(const float* half, int reach, Patch& patch);

  /// Weighted sums over the gradients, which are central differences (not halved).
  GradientMoments (*moments)(const Patch& patch, const PatchWeights& window);

  /// The sums of all samples times the weights of each filter.
  /// @param sums  PatchFilters::kCount values
  void (*filter)(const Patch& patch, const PatchFilters& filters, float* sums);

  /// As sample() and filter() in a third of the time, for samples along the rows and columns of the image.
  /// The samples are rounded at other places, so sums differ slightly.
  /// @param grid  across_x = down_y > 0, and at most kMaxUpright; across_y and down_x are 0. In every row
  /// that the samples touch, kUprightSlack pixels after the last one that they need may be read.
  void (*filter_upright)(const PatchGrid& grid, const PatchFilters& filters, float* sums);

  static constexpr std::int32_t kMaxUpright = 4 * 65536;
  static constexpr int kUprightSlack = 32;

  /// Distributes the weighted length of the gradients of rows 0, 2, 4... linearly over the two bins next to
  /// the direction; the middle of bin k is the direction k / 36 of a turn. Lengths are rounded to 2^-12 of
  /// the largest possible one. The sum of the weights is at most 280.
  void (*directions)(const Patch& patch, const PatchWeights& window, DirectionCounts& counts);

  /// The SIFT descriptor of a patch: 4 x 4 cells with 8 directions each, normalised, clipped at 0.2 and
  /// normalised to the length 512 in whole numbers of at most 255. Returns false where the patch has only one
  /// grey value.
  /// @param descriptor  CellTables::kLength values
  bool (*describe)(const Patch& patch, const CellTables& tables, float* descriptor);

  static constexpr int kMaxReach = 8;
};

}  // namespace corrsel::core
