#include "corrsel/selectors/neighbours.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace corrsel::core {
namespace {

constexpr double kPointsPerCell = 3.0;
constexpr int kMaxCellsPerSide = 2048;

struct Bounds {
  float low, high;
};

/// Bounds of the central 96 % of the values: a few far points must not decide the cell size.
Bounds centralBounds(std::vector<float> values) {
  const auto rank = [&values](double share) {
    const auto nth =
        values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
  };
  return {rank(0.02), rank(0.98)};
}

struct Neighbour {
  double distance;  // squared, px^2
  std::uint32_t index;
  bool operator<(const Neighbour& other) const {
    return distance != other.distance ? distance < other.distance : index < other.index;
  }
};

}  // namespace

PlanarNeighbours::PlanarNeighbours(const float* x, const float* y, std::size_t count, int max_k)
    : max_k_(max_k) {
  if (count > 0) {
    const Bounds bx = centralBounds({x, x + count}), by = centralBounds({y, y + count});
    const double width = static_cast<double>(bx.high) - bx.low,
                 height = static_cast<double>(by.high) - by.low;
    // Points on a line still get cells along the line.
    const double area = std::max(width * height, std::max(width, height) * std::max(width, height) * 1e-6);
    cell_ = std::sqrt(area * kPointsPerCell / static_cast<double>(count));
    cell_ = std::max({cell_, width / kMaxCellsPerSide, height / kMaxCellsPerSide, 1e-6});
    origin_x_ = bx.low;
    origin_y_ = by.low;
    inverse_cell_ = static_cast<float>(1.0 / cell_);
    columns_ = static_cast<int>(width / cell_) + 1;
    rows_ = static_cast<int>(height / cell_) + 1;
  }
  std::vector<std::uint32_t> cell_of(count);
  start_.assign(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_) + 1, 0);
  for (std::size_t i = 0; i < count; ++i) {
    cell_of[i] = static_cast<std::uint32_t>(cellY(y[i]) * columns_ + cellX(x[i]));
    ++start_[cell_of[i] + 1];
  }
  for (std::size_t cell = 1; cell < start_.size(); ++cell) start_[cell] += start_[cell - 1];
  points_.resize(count);
  std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
  for (std::size_t i = 0; i < count; ++i)
    points_[next[cell_of[i]]++] = {x[i], y[i], static_cast<std::uint32_t>(i)};

  // Of points at one place only the max_k lowest indices can ever be neighbours: crowds at one place cost
  // nothing.
  std::uint32_t kept = 0, begin = 0;
  for (std::size_t cell = 0; cell + 1 < start_.size(); ++cell) {
    const std::uint32_t end = start_[cell + 1];
    if (end - begin > static_cast<std::uint32_t>(max_k)) {
      std::sort(points_.begin() + begin, points_.begin() + end, [](const Point& a, const Point& b) {
        return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.index < b.index;
      });
    }
    int at_place = 0;
    start_[cell] = kept;
    for (std::uint32_t i = begin; i < end; ++i) {
      at_place = i > begin && points_[i].x == points_[i - 1].x && points_[i].y == points_[i - 1].y
                     ? at_place + 1
                     : 0;
      if (at_place < max_k) points_[kept++] = points_[i];
    }
    begin = end;
  }
  start_.back() = kept;
  points_.resize(kept);
}

int PlanarNeighbours::cellX(float x) const {
  return static_cast<int>(
      std::clamp((x - origin_x_) * inverse_cell_, 0.0F, static_cast<float>(columns_ - 1)));
}

int PlanarNeighbours::cellY(float y) const {
  return static_cast<int>(std::clamp((y - origin_y_) * inverse_cell_, 0.0F, static_cast<float>(rows_ - 1)));
}

int PlanarNeighbours::nearest(float x, float y, int k, std::uint32_t* out) const {
  constexpr int kLargest = 64;
  Neighbour best[kLargest];
  k = std::min({k, max_k_, kLargest});
  int found = 0;
  const auto visitCell = [&](int column, int row) {
    const std::size_t cell =
        static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(column);
    for (std::uint32_t i = start_[cell]; i < start_[cell + 1]; ++i) {
      const double dx = static_cast<double>(points_[i].x) - x, dy = static_cast<double>(points_[i].y) - y;
      const Neighbour candidate{dx * dx + dy * dy, points_[i].index};
      if (found == k && !(candidate < best[k - 1])) continue;
      int position = found < k ? found++ : k - 1;
      for (; position > 0 && candidate < best[position - 1]; --position) best[position] = best[position - 1];
      best[position] = candidate;
    }
  };

  const int column = cellX(x), row = cellY(y);
  for (int ring = 0;; ++ring) {
    const int left = column - ring, right = column + ring, top = row - ring, bottom = row + ring;
    for (int r = std::max(top, 0); r <= std::min(bottom, rows_ - 1); ++r) {
      if (r == top || r == bottom) {
        for (int c = std::max(left, 0); c <= std::min(right, columns_ - 1); ++c) visitCell(c, r);
      } else {
        if (left >= 0) visitCell(left, r);
        if (right < columns_ && ring > 0) visitCell(right, r);
      }
    }
    // Distance to the nearest side of the block behind which there still are cells; cells are assigned in
    // single precision, so a point may lie beyond its cell's side by a rounding error, which the margin
    // covers.
    double reach = std::numeric_limits<double>::infinity();
    if (left > 0) reach = std::min(reach, x - (origin_x_ + left * cell_));
    if (right < columns_ - 1) reach = std::min(reach, origin_x_ + (right + 1) * cell_ - x);
    if (top > 0) reach = std::min(reach, y - (origin_y_ + top * cell_));
    if (bottom < rows_ - 1) reach = std::min(reach, origin_y_ + (bottom + 1) * cell_ - y);
    reach -= 1e-3 * cell_;
    if (std::isinf(reach)) break;
    if (found == k && reach > 0 && best[k - 1].distance < reach * reach) break;
  }
  for (int i = 0; i < found; ++i) out[i] = best[i].index;
  return found;
}

}  // namespace corrsel::core
