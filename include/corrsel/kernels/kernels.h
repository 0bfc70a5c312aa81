#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace corrsel::core {

/// Instruction sets that the kernels are compiled for: the baseline is SSE2 on x86-64 and NEON on ARM.
enum class KernelLevel : std::uint8_t { kBaseline, kAvx2, kAvx512 };

std::string toString(KernelLevel level);

/// The levels that this build and this processor offer, lowest first.
std::vector<KernelLevel> supportedKernelLevels();

/// The level in use: the highest supported one, unless the environment variable CORRSEL_KERNELS (baseline,
/// avx2 or avx512) or setKernelLevel() says otherwise. Throws std::invalid_argument where the variable names
/// a level that does not exist or that the processor lacks.
KernelLevel kernelLevel();

/// For tests and measurements. Throws std::invalid_argument for a level that is not supported.
void setKernelLevel(KernelLevel level);

/// How a match is compared with a model; the number of the kernel in Kernels::errors and Kernels::score.
enum class Residual : std::uint8_t {
  kTransfer,           ///< |x' - Hx|^2
  kSymmetricTransfer,  ///< |x' - Hx|^2 + |x - H^-1 x'|^2
  kSampson             ///< squared Sampson distance of x'^T F x
};
constexpr std::size_t kResiduals = 3;

/// Four columns of equal length: left x, y, right x, y.
struct MatchColumns {
  const float *left_x, *left_y, *right_x, *right_y;
  std::size_t size;
};

/// A 3x3 matrix, row-major, and for Residual::kSymmetricTransfer its inverse, scaled so that the third
/// coordinate of both mappings is positive in front of the cameras.
struct ResidualModel {
  float forward[9];
  float backward[9];
};

/// What the score of a model counts, and when scoring gives up.
struct ScoreRule {
  float squared_threshold;  ///< a match with error <= this is an inlier
  float cost_per_error;  ///< cost of an inlier = error * this: kOutlierCost / threshold^2 is MSAC, 0 counts
                         ///< outliers
  std::int64_t limit;    ///< give up once the cost reaches this
  double squared_margin = 1e300;  ///< bail-out: give up once cost - limit * seen / matches is positive and
                                  ///< its square above this times `seen`
  std::size_t start = 0;          ///< first match; a multiple of kBlock. Matches are visited cyclically
  double log_consistent = 0;      ///< SPRT: ln(delta / epsilon), added per inlier; both 0 = no SPRT
  double log_inconsistent = 0;    ///< SPRT: ln((1 - delta) / (1 - epsilon)), added per outlier
  double log_decision = 0;        ///< SPRT: ln(A): reject above this

  static constexpr std::int32_t kOutlierCost = 65536;  ///< whole numbers add up alike in any order
  static constexpr std::size_t kBlock = 16;            ///< the SPRT decides after every block
};

struct ModelScore {
  std::int64_t cost = 0;    ///< sum over the matches seen
  std::size_t inliers = 0;  ///< among the matches seen
  std::size_t seen = 0;     ///< matches seen before giving up; all of them unless rejected
  bool rejected = false;    ///< by the limit or by the SPRT
  bool rejected_by_sprt = false;
};

/// Sums that Kernels::normal writes for a homography H, p = (x, y, 1) / w, (u, v) = H(x, y), w the third
/// coordinate, over the inliers: p_i p_j (6, i <= j), the same times u, times v, times u^2 + v^2; then
/// p (x' - u), p (y' - v), p (u (x' - u) + v (y' - v)) (3 each).
constexpr std::size_t kHomographySums = 33;

/// Sums that Kernels::normal writes for a fundamental matrix F, p = (x, y, 1), q = (x', y', 1), g = the
/// squared gradient of q^T F p, over the inliers: q_i q_j p_k p_l / g (36, i <= j outer, k <= l inner).
constexpr std::size_t kFundamentalSums = 36;

/// Points per group of the field kernels: their columns are as long as a multiple of it.
constexpr std::size_t kFieldGroup = 8;

/// K ~ L L^T, column by column, behind the two columns of the field samples u and v.
struct FieldFactor {
  const double* columns;  ///< column j starts at columns + j * stride
  std::size_t stride;     ///< >= padded
  std::size_t rank;       ///< columns of L, without u and v
  std::size_t padded;     ///< points, rounded up to whole groups
};

/// Pivots of the next columns of a factor.
struct FieldPivots {
  std::size_t count;
  const double *x, *y;  ///< their points
  const double* rest;   ///< what is left of the diagonal at each of them when its turn comes, > 0
  const double* rows;   ///< row c of L starts at rows + c * row_stride and holds rank + c elements
  std::size_t row_stride;
};

/// p = e / (e + outlier) with e = exp(exponent * squared residual).
struct FieldPosteriorRule {
  double exponent, outlier;
  double least;      ///< smaller posteriors are stored as this
  double threshold;  ///< posteriors above it are counted
};

struct FieldPosteriorSums {
  double weighted = 0;  ///< sum of p * squared residual
  double sum = 0;       ///< sum of p
  double clamped = 0;   ///< sum of max(p, least)
  double accepted = 0;  ///< number of p > threshold
};

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
/// least as large as whatever was left in the memory, and an entry stands for max(entry, base) - base
/// matches.
struct CountRow {
  std::uint32_t* counts;
  std::uint32_t base;
};

/// What GMS verifies a row of left cells by.
struct CellStatistics {
  CountRow rows[3];                  ///< above, the row itself, below
  const std::uint32_t* zeros;        ///< the counts of a cell outside
  const std::uint64_t* best;         ///< per left cell: the largest of (entry << 16) + 65535 - right cell
  const std::uint32_t* in_cell;      ///< matches per left cell, 0 for no_cell
  const LeftNeighbours* neighbours;  ///< per left cell
  std::uint32_t no_cell;             ///< stands for cells outside
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

  static constexpr int kMostNeighbours = 64;
};

/// Positions sorted by their cells; x and y are followed by 16 more floats of any value.
struct PointQueries {
  const float *x, *y;           ///< px
  const std::uint32_t* number;  ///< row of the answer
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

/// The hot loops, one set per level. All levels give bit-identical results: they run the same operations in
/// the same order, without contraction, on vectors of different width.
struct Kernels {
  /// Squared errors of matches [begin, end), written to out[0 .. end - begin). An error that does not exist
  /// (point behind the camera) is +Inf.
  void (*errors[kResiduals])(const ResidualModel& model, const MatchColumns& matches, std::size_t begin,
                             std::size_t end, float* out);

  /// Truncated cost and inliers of a model. O(matches seen).
  ModelScore (*score[kResiduals])(const ResidualModel& model, const MatchColumns& matches,
                                  const ScoreRule& rule);

  /// Parts of the normal equations over the matches with error <= squared_threshold; which sums, see above.
  void (*normal[kResiduals])(const ResidualModel& model, const MatchColumns& matches, float squared_threshold,
                             double* sums);

  /// The next columns of the pivoted Cholesky factor of exp(-beta d^2), to `added` at the factor's stride,
  /// and `rest`, the diagonal that is left. O(padded * count * rank). @return largest element of `rest`
  double (*field_factor)(const double* x, const double* y, double beta, const FieldPivots& pivots,
                         const FieldFactor& factor, double* added, double* rest);

  /// gram[j * m + k] = sum of weight * column j * column k, j <= k < m = rank + 2; below the diagonal it is
  /// undefined. `lanes`: scratch for m * m * kFieldGroup numbers. O(padded * m^2 / 2).
  void (*field_gram)(const FieldFactor& factor, const double* weight, double* lanes, double* gram);

  /// squared = |(u, v) - L w|^2, w row-major rank x 2. @return sum of weight * squared.
  double (*field_residuals)(const FieldFactor& factor, const double* coefficients, const double* weight,
                            double* squared);

  /// Posteriors of `size` points; the rest of the last group is set to 0.
  FieldPosteriorSums (*field_posteriors)(const FieldPosteriorRule& rule, const double* squared,
                                         std::size_t size, double* posterior);

  GmsKernels gms;
  NeighbourKernels neighbours;
};

/// The kernels of the level in use. Throws like kernelLevel().
const Kernels& kernels();

}  // namespace corrsel::core
