#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Columns of matches with the weight that each has as a vote. All columns are padded to a multiple of
/// kMultiple matches; the padding has finite coordinates and the weight 0.
struct VotingMatches {
  const float *left_x, *left_y, *right_x, *right_y;  ///< px
  const std::int32_t* weight;                        ///< in units of 1 / kOne
  std::size_t size;                                  ///< with the padding

  static constexpr std::size_t kMultiple = 16;
  static constexpr std::int32_t kOne = 4096;
};

/// An affine map that takes the left point (x, y) to the right point (u, v).
struct LocalMap {
  float a11, a12, a21, a22;  ///< linear part
  float x, y, u, v;          ///< px
};

/// Discs and tolerances of the support count. All lengths are in the right image.
struct SupportRule {
  static constexpr int kRadii = 4;
  static constexpr int kCoarseRadii =
      2;                         ///< the larger relative tolerance is used in the smallest discs only
  float squared_radius[kRadii];  ///< px^2, ascending
  float squared_rho[2];          ///< relative tolerances, fine and coarse
  float squared_floor;           ///< px^2: least tolerance; matches closer than this are the same point again
};

/// Sums of weights per disc.
struct SupportCounts {
  std::int64_t left[SupportRule::kRadii] = {};          ///< matches whose left point is mapped into the disc
  std::int64_t fine[SupportRule::kRadii] = {};          ///< of `left` those that the map predicts
  std::int64_t coarse[SupportRule::kCoarseRadii] = {};  ///< the same with the larger tolerance
};

/// The loops of local support.
struct SupportKernels {
  /// Counts the matches around a local map. O(matches).
  void (*count)(const VotingMatches& matches, const LocalMap& map, const SupportRule& rule,
                SupportCounts& counts);

  /// Counts the matches whose right points lie in the discs around (u, v). O(matches).
  void (*around)(const VotingMatches& matches, float u, float v, const SupportRule& rule,
                 std::int64_t (&counts)[SupportRule::kRadii]);
};

}  // namespace corrsel::core
