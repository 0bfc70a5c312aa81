#pragma once

#include "corrsel/neighbours.h"
#include "search/proposal.h"

namespace corrsel::core {

/// The matches near a match in both images.
///
/// Algorithm: of the 2 k matches that are nearest in the left image, the k with the smallest sum of the
/// squared distances in both images. That is nearly always the set of the k nearest matches in the four
/// dimensions of their coordinates. Equal distances are ordered by number. O(k) on average for evenly spread
/// points.
class MatchNeighbourhood {
 public:
  static constexpr int kMaxSize = 32;

  /// Copies the left points and refers to the right ones.
  void build(const NormalizedMatches& matches);

  /// Writes up to k matches near the match, itself excluded, in no particular order. @pre k <= kMaxSize
  /// @return how many were written
  int find(std::uint32_t match, int k, std::uint32_t* out) const;

 private:
  const NormalizedMatches* matches_ = nullptr;
  PlanarNeighbours neighbours_;
};

/// Samples of matches that are near one another.
///
/// Idea: inliers of one structure crowd, so pure samples are far more frequent than among uniform ones. Their
/// models are inaccurate and need local optimisation.
///
/// Algorithm: a sample consists of a uniform match and others among the k nearest to it, with k = 8, 16, 32
/// and all matches in turn. Where the quality is known, the first match is the next best one in every second
/// round, and the samples of all matches come from the prefixes of ProsacProposal.
///
/// Source: NAPSAC (Myatt et al., BMVC 2002) draws from a ball of fixed radius instead.
class LocalProposal final : public SampleProposal {
 public:
  LocalProposal();

 private:
  void prepare() override { near_.build(*matches_); }
  void drawSample(std::uint32_t* sample) override;

  MatchNeighbourhood near_;
};

}  // namespace corrsel::core
