#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/correspondences.h"
#include "points/point_groups.h"

namespace corrsel::core {

/// The matches that can be trusted before anything is known about the motion.
///
/// Idea: a motion that is estimated from these matches alone is not disturbed by the many outliers. It then
/// decides on all matches.
///
/// Algorithm: a match is trusted if its ratio of descriptor distances, nearest over second nearest, is below
/// `max_ratio` and is the smallest one among the matches whose right point is the same after rounding to
/// whole px. Of equal ratios, the first one in the order of the coordinates counts.
///
/// Input: the columns `distance` and `second_distance`. A match without a ratio is not trusted.
///
/// Cost: O(N) time; memory is kept between calls.
///
/// Source: ratio test of Lowe, IJCV 2004; the first step of GLPM (Ma et al., TGRS 2018) is of this kind.
class TrustedSet {
 public:
  /// With fewer trusted matches than this, an estimate from them alone is less safe than one from all.
  static constexpr std::size_t kMinMatches = 10;

  /// A sentence that names the missing column, or an empty text.
  /// @param who  what needs the column, e.g. "vfc with guided"
  static std::string missingInput(const Correspondences& matches, const char* who);

  /// @pre missingInput() returns an empty text
  void find(const Correspondences& matches, double max_ratio);

  /// Per match: 1 if it is trusted.
  const std::vector<std::uint8_t>& mask() const { return mask_; }

  /// The number of trusted matches.
  std::size_t size() const { return best_.size(); }

 private:
  // Of the matches with a ratio below the limit.
  std::vector<std::uint32_t> rows_;
  std::vector<float> ratio_, x_, y_;
  PointGroups right_points_;

  std::vector<std::uint32_t> best_;  // of each right point
  std::vector<std::uint8_t> mask_;
};

}  // namespace corrsel::core
