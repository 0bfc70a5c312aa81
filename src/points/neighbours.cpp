#include "corrsel/neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

// By measurement: fewer and too often a block of cells lacks neighbours, more and there are too many
// candidates.
constexpr double kPointsPerNeighbour = 0.6;
constexpr int kMaxCellsPerSide = 2048;

struct Bounds {
  float low, high;
};

/// Bounds of the values, but not far outside of where most of them are: a few far points must not decide the
/// cell size. Estimated from a sample; any bounds lead to the same neighbours. O(count).
Bounds bulkBounds(const float* values, std::size_t count) {
  constexpr std::size_t kSample = 256;
  float sample[kSample];
  const std::size_t size = std::min(count, kSample);
  for (std::size_t i = 0; i < size; ++i) {
    // Fractions of the golden ratio: no regular pattern of points can fool them.
    const std::uint64_t fraction = (i * 0x9E3779B1ULL) & 0xFFFFFFFFULL;
    sample[i] = values[size < kSample ? i : (fraction * count) >> 32];
  }
  const auto rank = [&sample, size](double share) {
    float* const nth = sample + static_cast<std::ptrdiff_t>(share * static_cast<double>(size - 1));
    std::nth_element(sample, nth, sample + size);
    return *nth;
  };
  const float low = rank(0.04), high = rank(0.96), slack = (high - low) / 4;
  Bounds bounds{values[0], values[0]};
  for (std::size_t i = 0; i < count; ++i) {
    bounds.low = std::min(bounds.low, values[i]);
    bounds.high = std::max(bounds.high, values[i]);
  }
  return {std::max(bounds.low, low - slack), std::min(bounds.high, high + slack)};
}

struct Neighbour {
  double distance;  // squared, px^2
  std::uint32_t number;
  bool operator<(const Neighbour& other) const {
    return distance != other.distance ? distance < other.distance : number < other.number;
  }
};

double squaredDistance(float ax, float ay, float bx, float by) {
  const double dx = static_cast<double>(ax) - bx, dy = static_cast<double>(ay) - by;
  return dx * dx + dy * dy;
}

/// Turns cells of points into the first place of every cell in the sorted order, and the end. O(count +
/// cells).
void countCells(const std::uint32_t* cells, std::size_t count, std::vector<std::uint32_t>& start) {
  std::fill(start.begin(), start.end(), 0U);
  std::uint32_t* const counts = start.data() + 1;
  for (std::size_t i = 0; i < count; ++i) ++counts[cells[i]];
  for (std::size_t cell = 1; cell < start.size(); ++cell) start[cell] += start[cell - 1];
}

}  // namespace

PlanarNeighbours::PlanarNeighbours(const float* x, const float* y, std::size_t count, int max_k) {
  build(x, y, count, max_k);
}

void PlanarNeighbours::Scratch::take(const float* from_x, const float* from_y, const std::uint32_t* rows,
                                     std::size_t count) {
  x.resize(count);
  y.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = from_x[rows[i]];
    y[i] = from_y[rows[i]];
  }
}

void PlanarNeighbours::build(const float* x, const float* y, std::size_t count, int max_k,
                             const std::uint32_t* members) {
  max_k_ = std::min(max_k, PointGrid::kMaxNeighbours);
  Scratch& work = scratch_;
  if (members != nullptr) {
    work.take(x, y, members, count);
    x = work.x.data();
    y = work.y.data();
  }
  layOut(x, y, count);
  x_.resize(count);
  y_.resize(count);
  number_.resize(count);
  work.cell.resize(count);
  kernels().neighbours.cells(grid(), x, y, count, work.cell.data());
  countCells(work.cell.data(), count, start_);
  work.next.assign(start_.begin(), start_.end() - 1);
  std::uint32_t* const next = work.next.data();
  const std::uint32_t* const cells = work.cell.data();
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t place = next[cells[i]]++;
    x_[place] = x[i];
    y_[place] = y[i];
    number_[place] = members != nullptr ? members[i] : static_cast<std::uint32_t>(i);
  }
  dropCrowds();
}

void PlanarNeighbours::layOut(const float* x, const float* y, std::size_t count) {
  columns_ = rows_ = 1;
  if (count > 0) {
    const Bounds bx = bulkBounds(x, count), by = bulkBounds(y, count);
    const double width = static_cast<double>(bx.high) - bx.low,
                 height = static_cast<double>(by.high) - by.low;
    // Points on a line get cells along the line: by area alone they would get far more cells than there are
    // points.
    const double cells = static_cast<double>(count) / (kPointsPerNeighbour * max_k_);
    cell_ = std::max({std::sqrt(width * height / cells), width / cells, height / cells,
                      width / kMaxCellsPerSide, height / kMaxCellsPerSide, 1e-6});
    origin_x_ = bx.low;
    origin_y_ = by.low;
    cells_per_px_ = static_cast<float>(1.0 / cell_);
    columns_ = static_cast<int>(width / cell_) + 1;
    rows_ = static_cast<int>(height / cell_) + 1;
  }
  start_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1);
}

/// Of points at one place only the max_k with the lowest numbers can ever be neighbours: crowds at one place
/// must cost nothing.
void PlanarNeighbours::dropCrowds() {
  std::vector<Point>& crowd = scratch_.crowd;
  std::uint32_t kept = 0, begin = 0;
  for (std::size_t cell = 0; cell + 1 < start_.size(); ++cell) {
    const std::uint32_t end = start_[cell + 1];
    start_[cell] = kept;
    const bool crowded = end - begin > static_cast<std::uint32_t>(max_k_);
    if (!crowded) {
      for (std::uint32_t i = begin; i < end && kept != begin; ++i) {
        x_[kept + i - begin] = x_[i];
        y_[kept + i - begin] = y_[i];
        number_[kept + i - begin] = number_[i];
      }
      kept += end - begin;
    } else {
      crowd.clear();
      for (std::uint32_t i = begin; i < end; ++i) crowd.push_back({x_[i], y_[i], number_[i]});
      std::sort(crowd.begin(), crowd.end(), [](const Point& a, const Point& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.number < b.number;
      });
      int at_place = 0;
      for (std::size_t i = 0; i < crowd.size(); ++i) {
        at_place = i > 0 && crowd[i].x == crowd[i - 1].x && crowd[i].y == crowd[i - 1].y ? at_place + 1 : 0;
        if (at_place >= max_k_) continue;
        x_[kept] = crowd[i].x;
        y_[kept] = crowd[i].y;
        number_[kept++] = crowd[i].number;
      }
    }
    begin = end;
  }
  start_.back() = kept;
}

PointGrid PlanarNeighbours::grid() const {
  return {x_.data(), y_.data(),     number_.data(), start_.data(), origin_x_,
          origin_y_, cells_per_px_, columns_,       rows_};
}

int PlanarNeighbours::nearest(float x, float y, int k, std::uint32_t* out) const {
  Neighbour best[PointGrid::kMaxNeighbours];
  k = std::min(k, max_k_);
  int found = 0;
  const auto visitCells = [&](int first, int last, int row) {
    const std::uint32_t* const start =
        start_.data() + static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_);
    for (std::uint32_t i = start[first]; i < start[last + 1]; ++i) {
      const Neighbour candidate{squaredDistance(x_[i], y_[i], x, y), number_[i]};
      if (found == k && !(candidate < best[k - 1])) continue;
      int position = found < k ? found++ : k - 1;
      for (; position > 0 && candidate < best[position - 1]; --position) best[position] = best[position - 1];
      best[position] = candidate;
    }
  };

  if (x_.empty() || k <= 0) return 0;
  std::uint32_t cell = 0;
  kernels().neighbours.cells(grid(), &x, &y, 1, &cell);
  const int row = static_cast<int>(cell) / columns_, column = static_cast<int>(cell) % columns_;
  for (int ring = 0;; ++ring) {
    const int left = column - ring, right = column + ring, top = row - ring, bottom = row + ring;
    // Only what exists of the ring: the whole search visits every cell at most once.
    const int first = std::max(left, 0), last = std::min(right, columns_ - 1);
    if (top >= 0) visitCells(first, last, top);
    for (const int side : {left, right}) {
      if (side < 0 || side >= columns_) continue;
      for (int r = std::max(top + 1, 0); r <= std::min(bottom - 1, rows_ - 1); ++r) visitCells(side, side, r);
    }
    if (ring > 0 && bottom < rows_) visitCells(first, last, bottom);
    // Distance to the nearest side of the block behind which there still are cells; cells are assigned in
    // single precision, so a point may lie beyond its cell's side by a rounding error, which the margin
    // covers.
    double reach = std::numeric_limits<double>::infinity();
    if (left > 0) reach = std::min(reach, x - (origin_x_ + left * cell_));
    if (right < columns_ - 1) reach = std::min(reach, origin_x_ + (right + 1) * cell_ - x);
    if (top > 0) reach = std::min(reach, y - (origin_y_ + top * cell_));
    if (bottom < rows_ - 1) reach = std::min(reach, origin_y_ + (bottom + 1) * cell_ - y);
    if (std::isinf(reach)) break;
    reach -= 1e-3 * cell_;
    if (found == k && reach > 0 && best[k - 1].distance < reach * reach) break;
  }
  for (int i = 0; i < found; ++i) out[i] = best[i].number;
  return found;
}

void PlanarNeighbours::nearestToAll(const float* x, const float* y, std::size_t count, int k,
                                    std::uint32_t* out, const std::uint32_t* queries) {
  constexpr std::size_t kBeyond = 16;  // floats that the kernel may read behind the end
  Scratch& work = scratch_;
  const NeighbourKernels& kernel = kernels().neighbours;
  const float *query_x = x, *query_y = y;
  if (queries != nullptr) {
    work.take(x, y, queries, count);
    query_x = work.x.data();
    query_y = work.y.data();
  }
  work.cell.resize(count);
  work.sorted_cell.resize(count);
  work.number.resize(count);
  work.doubtful.resize(count);
  work.sorted_x.resize(count + kBeyond);
  work.sorted_y.resize(count + kBeyond);
  kernel.cells(grid(), query_x, query_y, count, work.cell.data());
  work.next.resize(start_.size());
  countCells(work.cell.data(), count, work.next);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t place = work.next[work.cell[i]]++;
    work.sorted_x[place] = query_x[i];
    work.sorted_y[place] = query_y[i];
    work.sorted_cell[place] = work.cell[i];
    work.number[place] = static_cast<std::uint32_t>(i);
  }
  const PointQueries sorted_queries = {work.sorted_x.data(), work.sorted_y.data(), work.number.data(),
                                       work.sorted_cell.data(), count};
  const std::size_t doubts = kernel.nearest(grid(), sorted_queries, k, out, work.doubtful.data());

  for (std::size_t i = 0; i < doubts; ++i) {
    const std::uint32_t number = work.number[work.doubtful[i] / 2];
    std::uint32_t* const row = out + static_cast<std::size_t>(number) * static_cast<std::size_t>(k);
    if (work.doubtful[i] % 2 != 0) {
      nearest(query_x[number], query_y[number], k, row);
      continue;
    }
    Neighbour sorted[PointGrid::kMaxNeighbours];
    for (int j = 0; j < k; ++j) {
      const Neighbour next{squaredDistance(x[row[j]], y[row[j]], query_x[number], query_y[number]), row[j]};
      int position = j;
      for (; position > 0 && next < sorted[position - 1]; --position) sorted[position] = sorted[position - 1];
      sorted[position] = next;
    }
    for (int j = 0; j < k; ++j) row[j] = sorted[j].number;
  }
}

}  // namespace corrsel::core
