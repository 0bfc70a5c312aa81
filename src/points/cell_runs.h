#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "kernels/kernels.h"

namespace corrsel::core {

/// Sorts points into the cells of a grid, row by row, so that all points near a place stand in a few runs.
///
/// Every row is padded to a multiple of SupportRun::kMultiple slots, so that runs of whole multiples never
/// overlap. The outer cells are open-ended. The memory is kept between calls.
class CellRuns {
 public:
  static constexpr std::size_t kMostRows = 64;

  /// @param x, y  `count` finite coordinates
  /// @param low, high  corners of the part of the plane where most points lie
  /// O(count).
  void build(const float* x, const float* y, std::size_t count, std::array<double, 2> low,
             std::array<double, 2> high);

  /// The number of slots, with the padding.
  std::size_t slots() const { return start_.empty() ? 0 : start_.back(); }

  /// The slot of every point.
  const std::vector<std::uint32_t>& slotOf() const { return slot_; }

  /// Writes the runs, at most kMostRows, that hold all points within half_width and half_height of (x, y),
  /// and some others.
  /// @return the number of runs
  std::size_t find(double x, double y, double half_width, double half_height, SupportRun* runs) const;

 private:
  std::size_t column(double x) const;
  std::size_t row(double y) const;

  std::array<double, 2> low_{}, cells_per_px_{};
  std::size_t side_ = 1;
  std::vector<std::uint32_t> start_;  // first slot of every cell; every row has one more entry, for its end
  std::vector<std::uint32_t> cell_, slot_;
};

}  // namespace corrsel::core
