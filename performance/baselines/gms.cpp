#include <algorithm>
#include <cmath>

#include "baselines.h"

namespace corrsel::baselines {
namespace {

constexpr int kSide = 20, kNoCell = -1;
constexpr double kAlpha = 4;
constexpr double kScales[5] = {1.0, 0.5, 0.70710678118654752, 1.41421356237309505, 2.0};
// Neighbours clockwise from the upper left: (column, row).
constexpr int kRing[8][2] = {{-1, -1}, {0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}, {-1, 1}, {-1, 0}};

/// Coordinate as a share of the image's side; NaN for points more than a pixel outside.
double share(float position, int size) {
  if (!(position >= -1 && position <= size)) return std::nan("");
  return std::clamp(double(position) / size, 0.0, std::nextafter(1.0, 0.0));
}

/// Cell of a point in a grid shifted by (dx, dy) cells.
int cellOf(double x, double y, int side, double dx, double dy) {
  if (std::isnan(x) || std::isnan(y)) return kNoCell;
  const int column = int(std::floor(x * side + dx)), row = int(std::floor(y * side + dy));
  return column < side && row < side ? row * side + column : kNoCell;
}

int neighbour(int cell, const int (&offset)[2], int side) {
  const int column = cell % side + offset[0], row = cell / side + offset[1];
  return column < 0 || row < 0 || column >= side || row >= side ? kNoCell : row * side + column;
}

struct Points {
  std::vector<double> left_x, left_y, right_x, right_y;
};

/// One variant: right grid of the given size, ring of neighbours turned by `rotation` places.
Mask oneVariant(const Points& points, int right_side, int rotation) {
  const std::size_t n = points.left_x.size();
  const int left_cells = kSide * kSide, right_cells = right_side * right_side;
  Mask mask(n, 0);
  std::vector<int> left(n), right(n), counts, in_cell, partner(std::size_t(left_cells), kNoCell);
  const auto pairs = [&](int l, int r) -> int& { return counts[std::size_t(l * right_cells + r)]; };
  for (std::size_t i = 0; i < n; ++i)
    right[i] = cellOf(points.right_x[i], points.right_y[i], right_side, 0, 0);
  for (int shift = 0; shift < 4; ++shift) {
    const double dx = shift & 1 ? 0.5 : 0, dy = shift & 2 ? 0.5 : 0;
    counts.assign(std::size_t(left_cells * right_cells), 0);
    in_cell.assign(std::size_t(left_cells), 0);
    for (std::size_t i = 0; i < n; ++i) {
      left[i] = cellOf(points.left_x[i], points.left_y[i], kSide, dx, dy);
      if (left[i] == kNoCell || right[i] == kNoCell) continue;
      ++pairs(left[i], right[i]);
      ++in_cell[std::size_t(left[i])];
    }
    for (int cell = 0; cell < left_cells; ++cell) {
      partner[std::size_t(cell)] = kNoCell;
      if (in_cell[std::size_t(cell)] == 0) continue;
      const int* row = &pairs(cell, 0);
      const int best = int(std::max_element(row, row + right_cells) - row);
      int score = row[best], in_cells = in_cell[std::size_t(cell)], cells = 1;
      for (int k = 0; k < 8; ++k) {
        const int l = neighbour(cell, kRing[k], kSide);
        const int r = neighbour(best, kRing[(k + rotation) % 8], right_side);
        if (l == kNoCell || r == kNoCell) continue;
        score += pairs(l, r);
        in_cells += in_cell[std::size_t(l)];
        ++cells;
      }
      if (score >= kAlpha * std::sqrt(double(in_cells) / cells)) partner[std::size_t(cell)] = best;
    }
    for (std::size_t i = 0; i < n; ++i) {
      if (left[i] != kNoCell && right[i] != kNoCell && partner[std::size_t(left[i])] == right[i]) mask[i] = 1;
    }
  }
  return mask;
}

}  // namespace

Mask gmsTextbook(const core::Correspondences& m, bool rotation, bool scale) {
  Points points;
  for (std::size_t i = 0; i < m.size(); ++i) {
    points.left_x.push_back(share(m.left_x[i], m.left_size.width));
    points.left_y.push_back(share(m.left_y[i], m.left_size.height));
    points.right_x.push_back(share(m.right_x[i], m.right_size.width));
    points.right_y.push_back(share(m.right_y[i], m.right_size.height));
  }
  Mask best(m.size(), 0);
  std::ptrdiff_t max_selected = 0;
  for (int s = 0; s < (scale ? 5 : 1); ++s) {
    for (int r = 0; r < (rotation ? 8 : 1); ++r) {
      const Mask mask = oneVariant(points, int(std::lround(kSide * kScales[s])), r);
      const auto selected = std::count(mask.begin(), mask.end(), 1);
      if (selected <= max_selected) continue;
      max_selected = selected;
      best = mask;
    }
  }
  return best;
}

}  // namespace corrsel::baselines
