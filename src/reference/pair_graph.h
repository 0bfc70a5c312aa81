#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "corrsel/neighbours.h"
#include "kernels/kernels.h"

namespace corrsel::core {

/// Pairs of neighbouring matches, and how well the local maps of a pair predict each other.
///
/// Idea: the agreement of all pairs of matches takes N^2 time and memory. Outliers are found as well
/// from the pairs of near matches, of which there are N K.
///
/// Algorithm: every match i is joined to the K matches j whose left points are nearest. With the local maps
/// T_i(x) = x'_i + A_i (x - x_i), the error of a pair is the mean of |T_i(x_j) - x'_j|, |T_j(x_i) - x'_i|,
/// |T_i^-1(x'_j) - x_j| and |T_j^-1(x'_i) - x_i|, the dissimilarity of ACC. Pairs whose left or right points
/// lie within 1 px have no edge, because several orientations or scales at one corner are one observation.
///
/// Cost: O(N K) time; the neighbours take 4 N K bytes, which are kept between calls. Errors are computed when
/// they are asked for.
///
/// Source: Cho, Lee and Lee, ICCV 2009.
class PairGraph {
 public:
  static constexpr int kMaxNeighbours = PointGrid::kMaxNeighbours - 1;
  /// The error of a pair without an edge.
  static constexpr float kNoEdge = std::numeric_limits<float>::infinity();

  /// @param matches  n distinct matches with invertible maps; not kept
  /// @param k        neighbours of a match, at most kMaxNeighbours
  void build(const PairColumns& matches, std::size_t n, int k);

  std::size_t size() const { return nodes_.size(); }

  /// Neighbours of each match: k, or all other matches where there are fewer.
  std::size_t degree() const { return degree_; }

  /// The degree() neighbours of a match, nearest first.
  const std::uint32_t* neighbours(std::size_t match) const { return lists_.data() + match * degree_; }

  /// Writes the errors of a match with its neighbours, px.
  void errors(std::size_t match, float* out) const;

 private:
  struct Node {
    float left[2], right[2], map[4], inverse[4];
  };

  PlanarNeighbours index_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> lists_;
  std::size_t degree_ = 0;
};

}  // namespace corrsel::core
