#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// A grid of side x side cells over an image. A coordinate belongs to cell floor(x * side / width), whole
/// numbers included exactly; positions up to one pixel outside are pulled in.
struct ImageGrid {
  double columns_per_px, rows_per_px;  ///< side / size, enlarged by 2^-40: more than the product is rounded,
                                       ///< less than any other float can come near a whole number
  float width, height;                 ///< of the image, px
  std::int32_t side;                   ///< at most 200
  std::int32_t outside;                ///< the number of positions farther out
};

/// The left cells of half a cell in the four grids of GMS; bit 0 of the shift is in x, bit 1 in y.
struct ShiftedCells {
  std::uint16_t shifted[4];
};

/// Matches as pairs of cells.
struct CellPairs {
  const std::uint16_t *left_half, *right;  ///< half cell on the left, cell on the right
  const ShiftedCells* cells_of_half;       ///< by half cell
  std::size_t size;
};

/// The eight neighbours of a left cell, clockwise from the upper left; those outside are `no_cell`.
struct LeftNeighbours {
  std::uint32_t cell[8];
  std::int32_t inside;  ///< neighbours that exist
};

/// The counts of GMS in one row of left cells, row-major: side + 1 left cells, the last of which takes
/// matches without a left cell, x right cells. Counts never need clearing: every use has its own `base`, at
/// least as large as the values that the previous use left, and an entry represents max(entry, base) - base
/// matches.
struct CountRow {
  std::uint32_t* counts;
  std::uint32_t base;
};

/// Input of the verification of a row of left cells by GMS.
struct CellStatistics {
  CountRow rows[3];                  ///< above, the row itself, below
  const std::uint32_t* zeros;        ///< the counts of a cell outside
  const std::uint64_t* best;         ///< per left cell: the largest of (entry << 16) + 65535 - right cell
  const std::uint32_t* in_cell;      ///< matches per left cell, 0 for no_cell
  const LeftNeighbours* neighbours;  ///< per left cell
  std::uint32_t no_cell;             ///< number of all cells outside
  std::int32_t row, left_side, right_side;
  double alpha;

  static constexpr std::uint32_t kNoPartner = 0xFFFFFF00U;  ///< the decision on a cell without matches
};

/// The loops of GMS.
struct GmsKernels {
  /// Cell of every position.
  void (*cells)(const float* x, const float* y, std::size_t n, const ImageGrid& grid, std::uint16_t* out);

  /// Counts matches [begin, end), whose left cells lie in a row of one shifted grid.
  void (*count)(const CellPairs& pairs, std::size_t begin, std::size_t end, int shift, std::int32_t row,
                std::int32_t left_side, std::size_t right_cells, const CountRow& counts, std::uint64_t* best);

  /// Per left cell of the row: partner << 8 | bit r where the pair is accepted under rotation r; one or eight
  /// rotations.
  void (*verify)(const CellStatistics& statistics, std::uint32_t* decisions);
  void (*verify_rotations)(const CellStatistics& statistics, std::uint32_t* decisions);

  /// Per match: the rotations under which it lies in an accepted pair of cells of any grid.
  void (*vote)(const CellPairs& pairs, const std::uint32_t* const (&decisions)[4], std::uint8_t* votes);

  /// Votes per rotation.
  void (*count_votes)(const std::uint8_t* votes, std::size_t n, std::uint32_t (&counts)[8]);
};

/// Points sorted by the cells of a grid whose outer cells are open-ended.
struct PointGrid {
  const float *x, *y;           ///< px, cell by cell
  const std::uint32_t* number;  ///< of every point
  const std::uint32_t* start;   ///< first point of every cell, row by row, and the end
  float origin_x, origin_y, cells_per_px;
  std::int32_t columns, rows;

  static constexpr int kMaxNeighbours = 64;
};

/// Positions sorted by their cells; x and y are followed by 16 more floats of any value.
struct PointQueries {
  const float *x, *y;           ///< px
  const std::uint32_t* number;  ///< row of the result
  const std::uint32_t* cell;    ///< ascending
  std::size_t size;
};

/// The loops of nearest neighbours on a grid.
struct NeighbourKernels {
  /// Cell of every position.
  void (*cells)(const PointGrid& grid, const float* x, const float* y, std::size_t n, std::uint32_t* out);

  /// Writes the numbers of the k nearest points, nearest first, to out[number * k ..]. Where single precision
  /// or the block of cells looked at leaves doubts, 2 * position of the query is added to `doubtful`, plus 1
  /// if more is in doubt than the order of the k found; in that case nothing is written.
  /// @return the number of doubtful queries
  std::size_t (*nearest)(const PointGrid& grid, const PointQueries& queries, int k, std::uint32_t* out,
                         std::uint32_t* doubtful);

  /// Per row of two lists of numbers: bit 8 a + b where left[a] is right[b], a and b below `listed` <= 8.
  /// Rows are `stride` apart; 8 numbers are read from every one.
  void (*common)(const std::uint32_t* left, const std::uint32_t* right, std::size_t stride, int listed,
                 std::size_t n, std::uint64_t* out);
};

}  // namespace corrsel::core
