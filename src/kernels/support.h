#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/residual.h"

namespace corrsel::core {

/// Columns of matches with the weight that each has as a vote. Slots without a match have the weight 0.
struct VotingMatches {
  const float *left_x, *left_y, *right_x, *right_y;  ///< px, finite
  const std::int32_t* weight;                        ///< the sum of all weights is below 2^31
};

/// Consecutive slots of the columns; both ends are multiples of kMultiple, and runs do not overlap.
struct SupportRun {
  std::uint32_t begin, end;

  static constexpr std::size_t kMultiple = 16;
};

/// An affine map that takes the left point (x, y) to the right point (u, v).
struct LocalMap {
  float a11, a12, a21, a22;  ///< linear part
  float x, y, u, v;          ///< px
};

/// Discs around the right point of a match, and tolerances. All lengths are in the right image.
struct SupportRule {
  static constexpr int kRadii = 2, kTolerances = 2;
  float squared_radius[kRadii];    ///< px^2, ascending
  float squared_rho[kTolerances];  ///< tolerances relative to the length of the predicted displacement
  float squared_floor;  ///< px^2: smallest tolerance; matches closer than this are the same point again
};

/// Sums of weights.
struct SupportCounts {
  std::int32_t left[SupportRule::kRadii];  ///< matches whose left point is mapped into the disc
  std::int32_t supporters[SupportRule::kRadii][SupportRule::kTolerances];  ///< those that the map predicts
};

/// Affine maps side by side: x' = m[0] x + m[1] y + m[2], y' = m[3] x + m[4] y + m[5].
struct AffineMaps {
  static constexpr std::size_t kMaps = 16;
  float m[6][kMaps];
};

/// An affine map between displacements from a match in the left and in the right image: u = p[0] dx + p[2] dy
/// + p[4], v = p[1] dx + p[3] dy + p[5].
struct GrowingMap {
  float p[6];
  float left_x, left_y, right_x, right_y;  ///< of the match, px
  float squared_radius;                    ///< of the predicted displacements, px^2
  float squared_rho;                       ///< tolerance relative to the length of the predicted displacement
  float squared_floor;                     ///< smallest tolerance, px^2
};

/// The loops of local support. Each exists for both radii and tolerances, and for the first ones alone.
/// O(slots).
struct SupportKernels {
  /// Counts the matches around a local map.
  void (*both)(const VotingMatches& matches, const SupportRun* runs, std::size_t count, const LocalMap& map,
               const SupportRule& rule, SupportCounts& counts);
  void (*first)(const VotingMatches& matches, const SupportRun* runs, std::size_t count, const LocalMap& map,
                const SupportRule& rule, SupportCounts& counts);

  /// Counts the matches whose right points lie in the discs around (u, v). The left columns are not used.
  void (*around_both)(const VotingMatches& matches, const SupportRun* runs, std::size_t count, float u,
                      float v, const SupportRule& rule, std::int32_t* counts);
  void (*around_first)(const VotingMatches& matches, const SupportRun* runs, std::size_t count, float u,
                       float v, const SupportRule& rule, std::int32_t* counts);

  /// Adds up max(0, 1 - squared error * inverse_squared_tolerance) over the matches, which are added in
  /// their order, for each of the maps.
  void (*affine_gains)(const AffineMaps& maps, const MatchColumns& matches, float inverse_squared_tolerance,
                       float* gains);

  /// Writes the numbers of the matches that a map predicts, and their squared tolerances. Both have room for
  /// kMaxVectorLength more.
  /// @return how many were written
  std::size_t (*supporters)(const MatchColumns& matches, const GrowingMap& map, std::uint32_t* numbers,
                            float* tolerances);
  static constexpr std::size_t kMaxVectorLength = 16;
};

}  // namespace corrsel::core
