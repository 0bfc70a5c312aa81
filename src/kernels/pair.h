#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Measure of the agreement of two matches; the number of the kernel in PairKernels::block.
enum class PairValue : std::uint8_t {
  kRatio,       ///< smaller / larger of their distances in the two images
  kDifference,  ///< 1 - scale * (difference of these distances)^2, at least 0
  kPayoff       ///< 2^(-scale * error), error = the larger L1 error with which one's frame predicts the other
};

/// Columns of equal length, a multiple of PairBlock::kColumns; padding is finite. No two matches are
/// equal.
struct PairColumns {
  const float *left_x, *left_y, *right_x, *right_y;
  const float *a11, *a12, *a21, *a22;  ///< kPayoff: maps offsets in the left image to the right one
  std::size_t size;
};

struct PairRule {
  float scale = 0;              ///< kDifference: 1/px^2, kPayoff: 1/px
  bool one_to_one = false;      ///< matches that share one point only: conflict; kDifference, kPayoff: 0
  float threshold = 0;          ///< values up to this conflict
  float squared_threshold = 0;  ///< kRatio: threshold^2, or negative where nothing conflicts
  float noise_floor = 0;        ///< px: distances that differ by no more than this do not conflict
};

/// How values in [0, 1] are stored: kOne is 1, rounded to the nearest. Groups of kColumns columns follow one
/// another, each holding kRows rows.
struct PairBlock {
  static constexpr std::size_t kRows = 4, kColumns = 16;
  static constexpr float kOne = 65535.0F;
};

/// Values of all pairs of matches.
struct PairKernels {
  /// The values of rows [row, row + kRows) with columns [begin, end), both multiples of kColumns, as a block.
  void (*block[3])(const PairColumns& matches, const PairRule& rule, std::size_t row, std::size_t begin,
                   std::size_t end, std::uint16_t* block);

  /// alive[j] = 0 for the matches j in [begin, end), multiples of kColumns, that conflict with match `row`.
  void (*conflicts[2])(const PairColumns& matches, const PairRule& rule, std::size_t row, std::size_t begin,
                       std::size_t end, std::int32_t* alive);

  /// Payoffs of match `row` with matches [0, end), end being a multiple of kColumns.
  void (*payoff_row)(const PairColumns& matches, const PairRule& rule, std::size_t row, std::size_t end,
                     float* out);

  /// y_rows += B v and y += B^T v_rows for a block of kRows rows, B in units of 1 / kOne.
  void (*product)(const std::uint16_t* block, std::size_t columns, const float* v_rows, const float* v,
                  float* y, double* y_rows);
};

}  // namespace corrsel::core
