#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace corrsel::core {

/// The points of one image, those at one place under one number.
///
/// Idea: detectors find one corner several times, at several scales and orientations, and many left features
/// may share one right feature. Such matches are evidence only once.
///
/// Algorithm: points are at one place if their coordinates are equal after rounding to multiples of a cell.
/// Groups are numbered in the order of their first appearance.
class PointGroups {
 public:
  enum class Rounding : std::uint8_t {
    kNearest,  ///< a place reaches half a cell to each side of a multiple of the cell
    kDown      ///< a place is a cell of the grid that begins at (0, 0)
  };

  /// Forgets the points of the previous call and keeps the memory. Where a coordinate is 10^9 cells or more,
  /// points are compared exactly. O(N).
  /// @param cell  in the unit of the coordinates; positive
  void number(const std::vector<float>& x, const std::vector<float>& y, double cell,
              Rounding rounding = Rounding::kNearest);

  std::vector<std::uint32_t> of;     ///< group of each point
  std::vector<std::uint32_t> sizes;  ///< points in each group

 private:
  template <bool exact>
  void numberCells(const std::vector<float>& x, const std::vector<float>& y, float inverse_cell, float shift);

  template <bool exact, class Slot>
  void numberWith(const std::vector<float>& x, const std::vector<float>& y, float inverse_cell, float shift,
                  std::vector<Slot>& table);

  // The table of few points is half as large, so that a cache holds it.
  std::vector<std::uint16_t> short_slots_;
  std::vector<std::uint32_t> slots_;
  std::vector<std::uint64_t> keys_;
};

}  // namespace corrsel::core
