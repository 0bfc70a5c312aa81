#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/neighbours.h"
#include "points/length_unit.h"
#include "points/occupied_cells.h"

namespace corrsel::core {

/// Looks at the matches with local support that a model does not explain.
///
/// Idea: which kind of model a scene needs is not a question of how well a model fits, but of what it leaves
/// over. A plane leaves isolated matches over, which are imprecise or belong to repeated structure. A scene
/// with depth leaves coherent groups over that one fundamental matrix explains, and several motions leave
/// groups over that none explains.
///
/// Algorithm: the leftover of a model are the members of the local set outside the model. The coherent
/// leftover are those of them for which more than half of the nearest matches, 8 in each image, among the
/// local set and the matches that the model explains, are outside the model, too. Neighbours within 4 units
/// (length_unit.h), at least 4 px, in both images are the same match again and do not count. Matches are
/// counted at distinct places (occupied_cells.h).
///
/// A leftover of c places is sizable if c >= 6, c > 0.04 (c + m) and c > 0.02 (N - m), where the model
/// explains m of the N matches. The last condition is there because chance and repeated structure make 0.3 to
/// 2 % of all outliers look locally supported.
///
/// Cost: O(N) time, memory is kept between calls.
class Leftover {
 public:
  /// @param matches  the memory must outlive the calls
  void assign(const Correspondences& matches) {
    matches_ = &matches;
    units_ = LengthUnits::of(matches).atLeast(1);
  }

  /// Coherent leftover, in distinct places.
  /// @param local      per match: 1 = has local support
  /// @param explained  per match: 1 = agrees with the model
  std::size_t coherent(const std::vector<std::uint8_t>& local, const std::vector<std::uint8_t>& explained);

  /// Whether a leftover of `count` places is more than chance and repeated structure leave over.
  /// @param explained  matches that the model explains
  bool isSizable(std::size_t count, std::size_t explained) const;

  /// Number of distinct places of the matches in a mask.
  std::size_t distinctPlaces(const std::vector<std::uint8_t>& mask) { return cells_.count(*matches_, mask); }

 private:
  static constexpr int kNearest = 8, kListed = 16;

  int countOutside(const std::uint32_t* nearest, int count, std::size_t member,
                   const std::vector<std::uint8_t>& explained, int& seen) const;

  const Correspondences* matches_ = nullptr;
  LengthUnits units_;
  std::vector<std::uint32_t> members_;
  std::vector<float> left_x_, left_y_, right_x_, right_y_;   // of the members
  std::vector<std::uint32_t> left_over_;                     // members that are not explained
  std::vector<std::uint32_t> nearest_left_, nearest_right_;  // members, kListed for each that is left over
  std::vector<std::uint8_t> coherent_;
  PlanarNeighbours left_, right_;
  OccupiedCells cells_;
};

}  // namespace corrsel::core
