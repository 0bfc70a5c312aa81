#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace corrsel::core {

/// Numbers clusters of matches as Selection::group does: the largest cluster is 0, and clusters of equal size
/// are in the order of their first matches. Memory is kept between calls.
class ClusterNumbers {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  /// @param cluster  of every match, in the order of the coordinates: a number below size.size(), or kNone
  ///                 for matches of no cluster
  /// @param size     of every cluster
  /// O(N + C log C) for N matches and C clusters.
  void assign(const std::vector<std::uint32_t>& cluster, const std::vector<std::uint32_t>& size);

  /// The number of clusters that have a match.
  std::size_t count() const { return order_.size(); }

  /// The number of the cluster; -1 for kNone.
  std::int32_t operator[](std::uint32_t cluster) const { return cluster == kNone ? -1 : number_[cluster]; }

 private:
  std::vector<std::uint32_t> order_;
  std::vector<std::int32_t> number_;
};

}  // namespace corrsel::core
