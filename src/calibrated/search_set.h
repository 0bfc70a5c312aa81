#pragma once

#include <cstdint>
#include <vector>

#include "corrsel/correspondences.h"
#include "points/point_groups.h"

namespace corrsel::core {

/// Chooses one match per point: the matches among which a pose is searched.
///
/// Idea: several features at one point share its match, and many left features share one right feature by
/// chance. One match per point has a larger share of inliers, and every agreement is evidence of its own.
///
/// Algorithm: of all matches that share a right point, the one of the smallest descriptor distance remains,
/// and of these that share a left point, the one of the smallest ratio to the second-nearest distance.
/// Matches without distances are compared by their probability. Without either, and where they are equal, the
/// first one remains. O(N).
class SearchSet {
 public:
  /// @param rows  of the matches that take part, in an order that does not depend on the input
  /// @return those that remain, in this order
  const std::vector<std::uint32_t>& choose(const Correspondences& matches,
                                           const std::vector<std::uint32_t>& rows);

  const std::vector<std::uint32_t>& rows() const { return rows_; }

 private:
  void keepBest(const std::vector<float>& x, const std::vector<float>& y);

  std::vector<std::uint32_t> rows_, best_;
  std::vector<float> x_, y_, costs_;
  PointGroups groups_;
};

}  // namespace corrsel::core
