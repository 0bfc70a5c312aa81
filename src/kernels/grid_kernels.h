#pragma once

// Points in the cells of a grid: the counts of GMS, and nearest neighbours with the comparison of their
// lists.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

/// Towards zero, and at most `last`; 0 for NaN.
inline std::int32_t cellAt(double place, double last) {
  place = place > 0 ? place : 0;
  return static_cast<std::int32_t>(place < last ? place : last);
}

void imageCellsKernel(const float* __restrict x, const float* __restrict y, std::size_t n,
                      const ImageGrid& grid, std::uint16_t* __restrict out) {
  const ImageGrid g = grid;
  const double last = g.side - 1;
  for (std::size_t i = 0; i < n; ++i) {
    const std::int32_t column = cellAt(static_cast<double>(x[i]) * g.columns_per_px, last);
    const std::int32_t row = cellAt(static_cast<double>(y[i]) * g.rows_per_px, last);
    // Without a branch, which would keep the loop from being vectorized.
    const std::int32_t inside = -static_cast<std::int32_t>((x[i] >= -1.0F) & (x[i] <= g.width) &
                                                           (y[i] >= -1.0F) & (y[i] <= g.height));
    out[i] = static_cast<std::uint16_t>(((row * g.side + column) & inside) | (g.outside & ~inside));
  }
}

void countPairsKernel(const CellPairs& pairs, std::size_t begin, std::size_t end, int shift, std::int32_t row,
                      std::int32_t left_side, std::size_t right_cells, const CountRow& counts,
                      std::uint64_t* best) {
  const std::uint32_t base = counts.base, side = static_cast<std::uint32_t>(left_side);
  const std::uint32_t first = static_cast<std::uint32_t>(row) * side;
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t left = pairs.cells_of_half[pairs.left_half[i]].shifted[shift];
    const std::uint32_t column = left - first < side ? left - first : side;
    const std::uint64_t right = pairs.right[i];
    std::uint32_t& entry = counts.counts[column * right_cells + right];
    const std::uint32_t count = (entry > base ? entry : base) + 1;
    entry = count;
    const std::uint64_t rank = (static_cast<std::uint64_t>(count) << 16) + (0xFFFF - right);
    best[left] = best[left] > rank ? best[left] : rank;
  }
}

void voteKernel(const CellPairs& pairs, const std::uint32_t* const (&decisions)[4],
                std::uint8_t* __restrict votes) {
  for (std::size_t i = 0; i < pairs.size; ++i) {
    const ShiftedCells cells = pairs.cells_of_half[pairs.left_half[i]];
    const std::uint32_t right = pairs.right[i];
    std::uint32_t vote = 0;
    for (int shift = 0; shift < 4; ++shift) {
      const std::uint32_t decision = decisions[shift][cells.shifted[shift]];
      vote |= decision >> 8 == right ? decision : 0;
    }
    votes[i] = static_cast<std::uint8_t>(vote);
  }
}

void countVotesKernel(const std::uint8_t* votes, std::size_t n, std::uint32_t (&counts)[8]) {
  for (int bit = 0; bit < 8; ++bit) {
    std::uint32_t count = 0;
    for (std::size_t i = 0; i < n; ++i) count += (static_cast<std::uint32_t>(votes[i]) >> bit) & 1U;
    counts[bit] = count;
  }
}

/// Whether no neighbour of a cell of a square grid lies outside.
inline bool hasAllNeighbours(std::int32_t column, std::int32_t row, std::int32_t side) {
  return column > 0 && row > 0 && column < side - 1 && row < side - 1;
}

// The ring of neighbours clockwise from the upper left, twice over, so that rotation r starts at r.
constexpr std::int32_t kRingColumn[15] = {-1, 0, 1, 1, 1, 0, -1, -1, -1, 0, 1, 1, 1, 0, -1};
constexpr std::int32_t kRingRow[15] = {-1, -1, -1, 0, 1, 1, 1, 0, -1, -1, -1, 0, 1, 1, 1};

/// A cell with its partner, and what its neighbours are compared by.
struct RingOfCell {
  const CellStatistics& s;
  std::int32_t cell, column_of_cell, partner;
  std::size_t right_cells;
  std::uint32_t own;           ///< matches of the cell in the partner
  const std::int64_t* offset;  ///< of the ring in the right grid

  const std::uint32_t* counts(int k) const {
    const auto place = static_cast<std::size_t>(column_of_cell + kRingColumn[k]);
    return s.neighbours[cell].cell[k] == s.no_cell ? s.zeros
                                                   : s.rows[kRingRow[k] + 1].counts + place * right_cells;
  }
};

/// The rotations that are accepted, one bit each, where all neighbours of the partner are inside: the same
/// cells take part under every rotation.
template <int kRotations>
inline std::uint32_t acceptedInside(const RingOfCell& ring) {
  const CellStatistics& s = ring.s;
  const LeftNeighbours& near = s.neighbours[ring.cell];
  std::uint32_t scores[8] = {};
  std::uint64_t in_cells = s.in_cell[ring.cell];
  for (int k = 0; k < 8; ++k) {
    in_cells += s.in_cell[near.cell[k]];
    const std::uint32_t base = s.rows[kRingRow[k] + 1].base;
    const std::uint32_t* const counts = ring.counts(k) + ring.partner;
    for (int rotation = 0; rotation < kRotations; ++rotation) {
      const std::uint32_t entry = counts[ring.offset[k + rotation]];
      scores[rotation] += (entry > base ? entry : base) - base;
    }
  }
  const double threshold =
      s.alpha * __builtin_sqrt(static_cast<double>(in_cells) / static_cast<double>(near.inside + 1));
  std::uint32_t accepted = 0;
  for (int rotation = 0; rotation < kRotations; ++rotation) {
    const double score = scores[rotation] + static_cast<double>(ring.own);
    accepted |= (score >= threshold ? 1U : 0U) << rotation;
  }
  return accepted;
}

/// The same where some neighbours of the partner are outside.
template <int kRotations>
inline std::uint32_t acceptedAtBorder(const RingOfCell& ring) {
  const CellStatistics& s = ring.s;
  const LeftNeighbours& near = s.neighbours[ring.cell];
  const std::int32_t row = ring.partner / s.right_side, column = ring.partner - row * s.right_side;
  std::uint32_t accepted = 0;
  for (int rotation = 0; rotation < kRotations; ++rotation) {
    std::uint64_t in_cells = s.in_cell[ring.cell], score = ring.own;
    std::int32_t taking_part = 1;
    for (int k = 0; k < 8; ++k) {
      const std::int32_t c = column + kRingColumn[k + rotation], r = row + kRingRow[k + rotation];
      if (near.cell[k] == s.no_cell || c < 0 || r < 0 || c >= s.right_side || r >= s.right_side) continue;
      ++taking_part;
      in_cells += s.in_cell[near.cell[k]];
      const std::uint32_t base = s.rows[kRingRow[k] + 1].base;
      const std::uint32_t entry = ring.counts(k)[ring.partner + ring.offset[k + rotation]];
      score += (entry > base ? entry : base) - base;
    }
    const double threshold =
        s.alpha * __builtin_sqrt(static_cast<double>(in_cells) / static_cast<double>(taking_part));
    accepted |= (static_cast<double>(score) >= threshold ? 1U : 0U) << rotation;
  }
  return accepted;
}

template <int kRotations>
void verifyKernel(const CellStatistics& s, std::uint32_t* decisions) {
  const std::uint32_t own_base = s.rows[1].base;
  std::int64_t offset[15];
  for (int k = 0; k < 15; ++k) offset[k] = kRingRow[k] * s.right_side + kRingColumn[k];
  const std::size_t right_cells =
      static_cast<std::size_t>(s.right_side) * static_cast<std::size_t>(s.right_side);
  const std::int32_t first = s.row * s.left_side;
  for (std::int32_t cell = first; cell < first + s.left_side; ++cell) {
    decisions[cell] = CellStatistics::kNoPartner;
    const std::uint64_t rank = s.best[cell];
    const std::uint32_t top = static_cast<std::uint32_t>(rank >> 16);
    if (top <= own_base) continue;
    const auto partner = static_cast<std::int32_t>(0xFFFF - (rank & 0xFFFF));
    const std::int32_t row = partner / s.right_side, column = partner - row * s.right_side;
    const RingOfCell ring = {s, cell, cell - first, partner, right_cells, top - own_base, offset};
    const std::uint32_t accepted = hasAllNeighbours(column, row, s.right_side)
                                       ? acceptedInside<kRotations>(ring)
                                       : acceptedAtBorder<kRotations>(ring);
    decisions[cell] = static_cast<std::uint32_t>(partner) << 8 | accepted;
  }
}

// Nearest neighbours. Keys are squared distances in single precision whose lowest bits are replaced by the
// number of the candidate. As floats they are positive, so their bits compare like whole numbers.

#if defined(__SSE2__) && !defined(__AVX2__)
// SSE2 lacks the smaller of two whole numbers, but has that of two floats.
typedef FloatV KeyV;
#else
typedef IntV KeyV;
#endif

inline KeyV smaller(KeyV a, KeyV b) {
#if defined(__SSE2__) && !defined(__AVX2__)
  return (KeyV)_mm_min_ps((__m128)a, (__m128)b);
#else
  return a < b ? a : b;
#endif
}

inline KeyV larger(KeyV a, KeyV b) {
#if defined(__SSE2__) && !defined(__AVX2__)
  return (KeyV)_mm_max_ps((__m128)a, (__m128)b);
#else
  return a > b ? a : b;
#endif
}

/// Larger than any distance between coordinates of at most 1e6 px.
constexpr float kNoNeighbour = 1e30F;
/// Keys below this have too little relative precision.
constexpr float kTiny = 1e-30F;
/// Numbers of candidates take at most this many bits of a key.
constexpr int kMaxCandidates = 2048;

/// Neighbouring queries in one row of cells, at most kWidth of them, and the block of cells around them.
struct QueryGroup {
  std::size_t first, size;
  std::int32_t left, right, top, bottom;  // columns and rows of the block, inclusive
  std::uint32_t begin[3], length[3];      // the block's points, by row; the queries' own row first
  std::uint32_t candidates;
};

inline QueryGroup groupAt(const PointGrid& grid, const PointQueries& queries, std::size_t first) {
  // A longer block would have more points that are far from a query than near ones.
  constexpr std::uint32_t kMaxColumns = 8;
  QueryGroup group;
  const std::uint32_t cell = queries.cell[first], row = cell / static_cast<std::uint32_t>(grid.columns);
  const std::uint32_t row_end = (row + 1) * static_cast<std::uint32_t>(grid.columns);
  const std::uint32_t end = cell + kMaxColumns < row_end ? cell + kMaxColumns : row_end;
  std::size_t last = first;
  while (last + 1 < queries.size && last + 1 - first < static_cast<std::size_t>(kWidth) &&
         queries.cell[last + 1] < end)
    ++last;
  group.first = first;
  group.size = last + 1 - first;
  const auto middle = static_cast<std::int32_t>(row);
  const std::int32_t row_begin = middle * grid.columns;
  group.left = static_cast<std::int32_t>(cell) - row_begin - 1;
  group.right = static_cast<std::int32_t>(queries.cell[last]) - row_begin + 1;
  group.left = group.left < 0 ? 0 : group.left;
  group.right = group.right < grid.columns ? group.right : grid.columns - 1;
  group.top = middle > 0 ? middle - 1 : 0;
  group.bottom = middle + 1 < grid.rows ? middle + 1 : middle;
  group.candidates = 0;
  const std::int32_t rows[3] = {middle, middle - 1, middle + 1};
  for (int k = 0; k < 3; ++k) {
    group.begin[k] = group.length[k] = 0;
    if (rows[k] < 0 || rows[k] >= grid.rows) continue;
    const std::uint32_t* const start = grid.start + static_cast<std::size_t>(rows[k] * grid.columns);
    group.begin[k] = start[group.left];
    group.length[k] = start[group.right + 1] - group.begin[k];
    group.candidates += group.length[k];
  }
  return group;
}

/// Squared distance, made a little smaller, within which no point outside the group's block can lie.
inline FloatV squaredReach(const PointGrid& grid, const QueryGroup& group, FloatV x, FloatV y) {
  // In units of cells and with the very operations that assign points to cells.
  const FloatV column = (x - grid.origin_x) * grid.cells_per_px;
  const FloatV row = (y - grid.origin_y) * grid.cells_per_px;
  FloatV reach = splat(kNoNeighbour);
  if (group.left > 0) reach = minimum(reach, column - static_cast<float>(group.left));
  if (group.right < grid.columns - 1) reach = minimum(reach, static_cast<float>(group.right + 1) - column);
  if (group.top > 0) reach = minimum(reach, row - static_cast<float>(group.top));
  if (group.bottom < grid.rows - 1) reach = minimum(reach, static_cast<float>(group.bottom + 1) - row);
  // Positions in cells are off by less than 4e-4 within the grid and by 2^-22 of themselves beyond it.
  reach = maximum(reach * 0.9999F - 1e-3F, FloatV{}) * (1.0F / grid.cells_per_px);
  return minimum(reach * reach * 0.9999F, splat(kNoNeighbour));
}

/// The kTracked smallest keys per lane; 0 = `tracked` of them.
template <int kTracked>
inline void smallestKeys(const PointGrid& grid, const QueryGroup& group, FloatV x, FloatV y,
                         std::int32_t mask, int tracked, KeyV* out) {
  constexpr auto kRoom = static_cast<std::size_t>(kTracked > 0 ? kTracked : PointGrid::kMaxNeighbours + 1);
  const int count = kTracked > 0 ? kTracked : tracked;
  KeyV best[kRoom];
  for (int j = 0; j < count; ++j) best[j] = (KeyV)splat(kNoNeighbour);
  std::int32_t candidate = 0;
  for (int run = 0; run < 3; ++run) {
    const float *px = grid.x + group.begin[run], *py = grid.y + group.begin[run];
    for (std::uint32_t i = 0; i < group.length[run]; ++i, ++candidate) {
      const FloatV dx = px[i] - x, dy = py[i] - y;
      KeyV key = (KeyV)(((IntV)(dx * dx + dy * dy) & ~mask) | candidate);
      // Skipping keys that no lane needs would cost more, in branches guessed wrongly.
      for (int j = 0; j < count; ++j) {
        const KeyV better = smaller(best[j], key);
        key = larger(best[j], key);
        best[j] = better;
      }
    }
  }
  for (int j = 0; j < count; ++j) out[j] = best[j];
}

template <int kTracked>
std::size_t nearestKernel(const PointGrid& grid, const PointQueries& queries, int k, std::uint32_t* out,
                          std::uint32_t* doubtful) {
  std::size_t doubts = 0;
  QueryGroup group;
  for (std::size_t first = 0; first < queries.size; first += group.size) {
    group = groupAt(grid, queries, first);
    if (group.candidates > kMaxCandidates) {
      for (std::size_t lane = 0; lane < group.size; ++lane)
        doubtful[doubts++] = static_cast<std::uint32_t>(2 * (first + lane) + 1);
      continue;
    }
    // At least five bits, so that keys a few steps apart differ by more than distances are rounded.
    const std::int32_t mask =
        static_cast<std::int32_t>((1U << (32 - __builtin_clz(group.candidates | 31U))) - 1U);
    const FloatV x = load(queries.x + first), y = load(queries.y + first);
    KeyV best[PointGrid::kMaxNeighbours + 1];
    smallestKeys<kTracked>(grid, group, x, y, mask, k + 1, best);

    // Keys closer than this may belong to distances in the other order.
    const std::int32_t close = 4 * (mask + 1);
    IntV order{};
    for (int j = 0; j + 1 < k; ++j) {
      order |= (IntV)best[j + 1] - (IntV)best[j] < close;
      order |= (FloatV)best[j + 1] < kTiny;
    }
    IntV members = (IntV)best[k] - (IntV)best[k - 1] < close;
    members |= (FloatV)best[k] < kTiny;
    members |= ~((FloatV)((IntV)best[k - 1] | mask) < squaredReach(grid, group, x, y));

    std::uint32_t positions[PointGrid::kMaxNeighbours][kWidth];
    const auto end0 = static_cast<std::int32_t>(group.length[0]);
    const auto end1 = static_cast<std::int32_t>(group.length[0] + group.length[1]);
    for (int j = 0; j < k; ++j) {
      const IntV candidate = (IntV)best[j] & mask;
      IntV position = candidate + static_cast<std::int32_t>(group.begin[0]);
      position =
          candidate >= end0 ? candidate + (static_cast<std::int32_t>(group.begin[1]) - end0) : position;
      position =
          candidate >= end1 ? candidate + (static_cast<std::int32_t>(group.begin[2]) - end1) : position;
      __builtin_memcpy(positions[j], &position, sizeof position);
    }
    const bool any_doubt = anyTrue(order | members);
    for (std::size_t lane = 0; lane < group.size; ++lane) {
      const int at = static_cast<int>(lane);
      if (any_doubt && (order[at] | members[at]) != 0) {
        doubtful[doubts++] = static_cast<std::uint32_t>(2 * (first + lane) + (members[at] != 0 ? 1U : 0U));
        if (members[at] != 0) continue;
      }
      std::uint32_t* const row =
          out + static_cast<std::size_t>(queries.number[first + lane]) * static_cast<std::size_t>(k);
      for (int j = 0; j < k; ++j) row[j] = grid.number[positions[j][lane]];
    }
  }
  return doubts;
}

std::size_t anyNearestKernel(const PointGrid& grid, const PointQueries& queries, int k, std::uint32_t* out,
                             std::uint32_t* doubtful) {
  // Lists of fixed length stay in registers: those of the LPM presets.
  if (k == 5) return nearestKernel<6>(grid, queries, k, out, doubtful);
  if (k == 9) return nearestKernel<10>(grid, queries, k, out, doubtful);
  return nearestKernel<0>(grid, queries, k, out, doubtful);
}

void pointCellsKernel(const PointGrid& grid, const float* __restrict x, const float* __restrict y,
                      std::size_t n, std::uint32_t* __restrict out) {
  const PointGrid g = grid;
  const float last_column = static_cast<float>(g.columns - 1), last_row = static_cast<float>(g.rows - 1);
  for (std::size_t i = 0; i < n; ++i) {
    float column = (x[i] - g.origin_x) * g.cells_per_px, row = (y[i] - g.origin_y) * g.cells_per_px;
    column = column > 0.0F ? column : 0.0F;
    column = column < last_column ? column : last_column;
    row = row > 0.0F ? row : 0.0F;
    row = row < last_row ? row : last_row;
    out[i] = static_cast<std::uint32_t>(static_cast<std::int32_t>(row) * g.columns +
                                        static_cast<std::int32_t>(column));
  }
}

/// Returns a mask whose bit k is set if values[k] is the value sought.
inline std::uint64_t equalBits(const std::uint32_t* values, std::uint32_t sought) {
#if defined(__AVX2__)
  const __m256i equal = _mm256_cmpeq_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(values)),
                                           _mm256_set1_epi32(static_cast<std::int32_t>(sought)));
  return static_cast<std::uint32_t>(_mm256_movemask_ps((__m256)equal));
#elif defined(__SSE2__)
  const __m128i wanted = _mm_set1_epi32(static_cast<std::int32_t>(sought));
  const __m128i low = _mm_loadu_si128(reinterpret_cast<const __m128i*>(values));
  const __m128i high = _mm_loadu_si128(reinterpret_cast<const __m128i*>(values + 4));
  return static_cast<std::uint32_t>(_mm_movemask_ps((__m128)_mm_cmpeq_epi32(low, wanted)) |
                                    _mm_movemask_ps((__m128)_mm_cmpeq_epi32(high, wanted)) << 4);
#else
  std::uint64_t bits = 0;
  for (int k = 0; k < 8; ++k) bits |= static_cast<std::uint64_t>(values[k] == sought) << k;
  return bits;
#endif
}

void commonKernel(const std::uint32_t* left, const std::uint32_t* right, std::size_t stride, int listed,
                  std::size_t n, std::uint64_t* out) {
  const std::uint64_t valid = (1ULL << listed) - 1ULL;
  for (std::size_t i = 0; i < n; ++i) {
    std::uint64_t pairs = 0;
    for (int a = 0; a < listed; ++a)
      pairs |= (equalBits(right + i * stride, left[i * stride + static_cast<std::size_t>(a)]) & valid)
               << (8 * a);
    out[i] = pairs;
  }
}

}  // namespace
}  // namespace corrsel::core
