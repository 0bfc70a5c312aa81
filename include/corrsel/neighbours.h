#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace corrsel::core {

struct PointGrid;

/// Exact k nearest neighbours among points in the plane.
///
/// The points are sorted into a uniform grid whose outer cells are open-ended, so that a few far points do
/// not determine the cell size. Neighbours are ordered by distance, computed in double precision, and equal
/// distances by the points' numbers. The result is therefore unique.
class PlanarNeighbours {
 public:
  PlanarNeighbours() = default;

  /// An index of the given points; see build().
  PlanarNeighbours(const float* x, const float* y, std::size_t count, int max_k);

  /// Replaces the points and keeps the memory.
  /// @param x, y     `count` finite coordinates, copied; a point's number is its position
  /// @param max_k    largest k that will be asked for, at most 64
  /// @param members  ascending numbers of the points to take, `count` of them; nullptr = all points
  /// O(count) time for evenly spread points, O(count log count) for crowded ones.
  void build(const float* x, const float* y, std::size_t count, int max_k,
             const std::uint32_t* members = nullptr);

  /// Writes the numbers of the min(k, count) nearest points to `out`, nearest first. A query that is itself
  /// in the set finds itself. About O(k) time for evenly spread points, O(count) at worst. Re-entrant.
  /// @return how many were written
  int nearest(float x, float y, int k, std::uint32_t* out) const;

  /// Writes the numbers of the k points nearest to every query to out[query * k ..]. The result is that of
  /// nearest() for each query. It is several times as fast, because neighbouring positions are searched
  /// together.
  /// @param x, y     the columns given to build(), px
  /// @param count    number of queries
  /// @param out      has room for count * k numbers
  /// @param queries  `count` positions in the columns, which are asked for; nullptr = 0 to count - 1
  /// @pre k <= max_k, and at least k points
  void nearestToAll(const float* x, const float* y, std::size_t count, int k, std::uint32_t* out,
                    const std::uint32_t* queries = nullptr);

 private:
  struct Point {
    float x, y;
    std::uint32_t number;
  };

  /// Memory of build() and nearestToAll(), kept between calls.
  struct Scratch {
    std::vector<float> x, y, sorted_x, sorted_y;
    std::vector<std::uint32_t> cell, sorted_cell, next, number, doubtful;
    std::vector<Point> crowd;

    /// Copies some of the points to x and y.
    void take(const float* from_x, const float* from_y, const std::uint32_t* rows, std::size_t count);
  };

  PointGrid grid() const;
  void layOut(const float* x, const float* y, std::size_t count);
  void dropCrowds();

  float origin_x_ = 0, origin_y_ = 0, cells_per_px_ = 1;
  double cell_ = 1;
  int columns_ = 1, rows_ = 1, max_k_ = 0;
  std::vector<float> x_, y_;  // sorted by cell
  std::vector<std::uint32_t> number_;
  std::vector<std::uint32_t> start_;  // first point of every cell, and the end
  Scratch scratch_;
};

}  // namespace corrsel::core
