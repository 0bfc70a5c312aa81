#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace corrsel::core {

/// Exact k nearest neighbours among points in the plane, by a uniform grid whose outer cells are open-ended,
/// so that a few far points do not spoil the cell size. Neighbours are ordered by (distance, index): the
/// result is unique.
class PlanarNeighbours {
 public:
  /// @param x, y   `count` finite coordinates, copied
  /// @param max_k  largest k that nearest() will be asked for, at most 64. O(count log count).
  PlanarNeighbours(const float* x, const float* y, std::size_t count, int max_k);

  /// Writes the min(k, count) nearest indices to `out`, nearest first; a query that is itself in the set
  /// finds itself. About O(k) for evenly spread points. @return number written. Re-entrant.
  int nearest(float x, float y, int k, std::uint32_t* out) const;

 private:
  struct Point {
    float x, y;
    std::uint32_t index;
  };
  int cellX(float x) const;
  int cellY(float y) const;

  float origin_x_ = 0, origin_y_ = 0, inverse_cell_ = 1;
  double cell_ = 1;
  int columns_ = 1, rows_ = 1, max_k_;
  std::vector<Point> points_;         // sorted by cell
  std::vector<std::uint32_t> start_;  // first point of every cell, and the end
};

}  // namespace corrsel::core
