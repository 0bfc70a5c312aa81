#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/random.h"
#include "geometry/normalization.h"

namespace corrsel::core {

/// Progressive NAPSAC: samples from neighbourhoods that grow with the number of times they have been tried.
///
/// Idea: inliers of one structure crowd in both images, so samples of near matches are purer, and those
/// of far matches give better models. The neighbourhood of a match therefore begins small and grows.
///
/// Algorithm: sample t consists of the t-th best match (the centre), a last match and m - 2 others. A match
/// that has been drawn h times has a neighbourhood of the smallest size n >= m with T'_n >= h, where
///   T_n = T_L prod_{i<m-1} (n-i)/(N-i), T'_{n+1} = T'_n + ceil(T_{n+1} - T_n), T'_n = 1 for n < m,
/// and L = N / 2 is the number of these samples; the search goes on with PROSAC. Neighbours are the matches
/// in the same cell of a grid in the four dimensions of the coordinates, with 16, 8, 4 or 2 cells along each:
/// the finest one whose cell holds n matches. They are ordered by quality. The last match of the sample is
/// the n-th of them, and the others are uniform among those before it.
///
/// Cost: O(N) to build, O(m + log N) per sample.
///
/// Source: Barath, Ivashechkin and Matas, arXiv:1906.02295, with L and the cells of the authors' Python
/// interface.
class GrowingNeighbourhoods {
 public:
  /// @param best_first  all matches; must outlive the object
  void build(const NormalizedMatches& matches, const std::vector<std::uint32_t>& best_first, int sample_size);

  /// Number L of local samples.
  std::uint64_t samples() const { return hits_.size() / 2; }

  /// Writes the local sample around the match of rank `centre`, counted from 0.
  /// @return false, with nothing written, where even the coarsest cell has too few matches
  bool draw(Random& random, std::uint32_t centre, std::uint32_t* sample);

  /// T'_n for n = 1..count, at [n - 1]. @param samples  L
  static void growth(std::size_t count, int sample_size, double samples, std::vector<std::uint64_t>& result);

 private:
  static constexpr int kLevels = 4;  // 16, 8, 4, 2 cells

  const std::vector<std::uint32_t>* best_first_ = nullptr;
  std::size_t sample_size_ = 0;
  std::vector<std::uint64_t> growth_;
  // All by rank.
  std::vector<std::uint16_t> cell_;  // on the finest level, 4 bits per dimension
  std::vector<std::uint32_t> hits_, size_;
  // The ranks in the cells of each level, ascending within a cell, and the first one of each cell.
  std::vector<std::uint32_t> members_[kLevels], begins_[kLevels];
};

}  // namespace corrsel::core
