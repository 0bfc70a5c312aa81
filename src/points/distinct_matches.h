#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"
#include "geometry/frame_map.h"
#include "kernels/kernels.h"

namespace corrsel::core {

/// Matches without their repetitions, in the order of their coordinates. What is computed from them does not
/// depend on the order of the input, and equal matches get the same result. Memory is kept between calls.
class DistinctMatches {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffU;

  /// @param maps  empty, or one map per match, which then counts as part of the match
  /// @param rows  the matches to take; ofRow() returns kNone for the others
  /// O(N log N) time.
  void assign(const Correspondences& matches, const std::vector<LinearMap>& maps,
              const std::vector<std::uint32_t>& rows);

  std::size_t size() const { return first_row_.size(); }

  /// Columns of size() matches, padded with zeros.
  PairColumns columns() const;

  /// The same columns with the matches in the given order. They are valid until the next call.
  PairColumns columns(const std::vector<std::uint32_t>& order);

  std::size_t multiplicity(std::size_t match) const { return multiplicity_[match]; }

  /// The lowest row of the input that holds this match.
  std::uint32_t firstRow(std::size_t match) const { return first_row_[match]; }

  /// The match in a row of the input, or kNone.
  std::uint32_t ofRow(std::size_t row) const { return of_row_[row]; }

 private:
  static constexpr std::size_t kColumns = 8;
  static PairColumns view(const std::vector<float>& values, std::size_t length);
  std::size_t paddedSize() const;

  std::vector<float> values_, ordered_;  // column after column
  std::vector<std::uint32_t> multiplicity_, first_row_, of_row_, order_;
};

}  // namespace corrsel::core
