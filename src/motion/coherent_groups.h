#pragma once

#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/neighbours.h"
#include "points/occupied_cells.h"

namespace corrsel::core {

/// Finds groups of neighbouring matches that move alike.
///
/// Algorithm:
///  1. Two matches agree if |v - u| <= 3 px + 0.3 |u|, where u and v are the differences of their left and of
///     their right points. A candidate is a seed if at least 3 of its 12 nearest candidates in the left image
///     agree with it. Those at the same place, within 3 px in one of the images, do not count.
///  2. Seeds that agree with each other as neighbours are in one group. A group needs 6 places
///     (occupied_cells.h), and more than 2 % of the number of candidates and of the number of its places and
///     the static matches together, because repeated structure makes as many wrong matches agree
///     (leftover.h).
///  3. Among the 8 nearest matches that are seeds of groups or static, a group has a share of its own. It is
///     dropped unless the mean of this share over its seeds exceeds a half in the left and in the right
///     image: wrong matches of repeated structure agree with each other, too, but correct matches lie between
///     them, at their own places or at those that they were taken for.
///  4. A match joins the group with the largest share around it if at least half of the seeds of this group
///     in the left image agree with it. A candidate needs 2 such seeds, and a static match more than half of
///     the 8.
///
/// Chance: 12 wrong neighbours at a distance of 60 px agree with a wrong match with a probability of 0.002
/// each in an image of 1024 x 768 px; three do so in one of 10^6 cases.
///
/// Cost: O(N). The memory is kept.
///
/// Source: own work; neighbours that move alike are the idea of LPM (lpm.h) and of others.
class CoherentGroups {
 public:
  /// @param matches    finite coordinates
  /// @param candidate  per match: 1 = may begin a group
  /// @param still      per match: 1 = belongs to the static scene, as far as it is known
  void find(const Correspondences& matches, const std::vector<std::uint8_t>& candidate,
            const std::vector<std::uint8_t>& still);

  /// Number of groups.
  std::size_t size() const { return members_.size(); }

  /// The rows of the matches of a group, ascending.
  const std::vector<std::uint32_t>& members(std::size_t group) const { return members_[group]; }

 private:
  void findSeeds();
  void unite();
  void listNearest(const std::vector<float>& x, const std::vector<float>& y);
  void dropInterleaved();
  bool isSizable(const std::vector<std::uint32_t>& rows);
  void join(const std::vector<std::uint8_t>& candidate);
  bool agree(std::uint32_t a, std::uint32_t b) const;
  std::uint32_t rootOf(std::uint32_t i);

  const Correspondences* matches_ = nullptr;
  std::size_t still_ = 0;   // static matches
  std::size_t listed_ = 0;  // nearest matches per match
  std::vector<std::uint32_t> candidates_, near_, parent_, points_;
  std::vector<std::uint8_t> seed_, in_;
  std::vector<std::int32_t> group_;  // of the seeds, per match; -1 = none
  std::vector<std::vector<std::uint32_t>> members_;
  PlanarNeighbours neighbours_;
  OccupiedCells cells_;
};

}  // namespace corrsel::core
