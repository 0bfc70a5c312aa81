#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct GaimOptions : ConfidenceOptions {
  int k = 63;               ///< neighbours of a match
  double theta = 0.4;       ///< energy of a match that is kept, before its rewards
  double lambda = 10;       ///< reward of a match all of whose neighbours agree
  double max_error = 15;    ///< error at which a pair of neighbours earns no reward, px
  bool one_to_one = false;  ///< keep only the best match of every left and every right point

  void visit(OptionVisitor& visitor) const override;
};

/// Graph-based affine-invariant matching in a binary form: each match is kept or dropped.
///
/// Idea: a match is kept if its descriptor is distinctive, or if the local maps of its neighbours that are
/// kept agree with its own. This is the minimum of an energy over a graph of neighbouring matches.
///
/// Algorithm: each match i is joined to the `k` matches j with the nearest left points. d_ij is the mean of
/// the four errors with which the local maps of two matches predict the points of each other, in both
/// directions and in both images. With the ratio of descriptor distances r_i, x_i = 1 for a match that is
/// kept and 0 for one that is dropped, and (a)+ = max(a, 0),
///
///     E(x) = sum_i x_i (theta - (1 - r_i) / 2) - lambda / (2 k) sum_ij x_i x_j (1 - d_ij / max_error)+
///
/// where the second sum goes over all i and the k neighbours j of each. Pairs that share a point (within 1
/// px) earn nothing. Starting with all matches kept, a match is dropped where this lowers E, until no match
/// is left for which it does (iterated conditional modes). As agreement is only rewarded, dropping a match
/// never makes another one better, so that none returns and the result does not depend on the order. It is
/// the largest set in which every match is worth its energy, and it contains the set with the smallest E of
/// all. With `one_to_one`, of the kept matches that share a right point (after rounding to whole px), only
/// the one with the largest reward remains, and then the same for left points.
///
/// What is the authors': Collins, Mesejo and Bartoli (ECCV 2014) match the features of two images by the
/// energy of a Markov random field, whose variables are the left features and whose values are several
/// candidates for each in the right image. The graph joins neighbouring features, the edges use the affine
/// parts of the features, and mismatches are found afterwards by the consistency of the matching from left to
/// right with that from right to left. Much of their gain comes from detectors that are run for repeatable
/// and dense features, before any matching.
///
/// What is ours: with a single candidate for each feature, the field has the values kept and dropped only.
/// This energy, its minimisation, the one-to-one rule in place of the second matching, and all constants are
/// ours.
///
/// Input: coordinates; the local affine frames of both features; descriptor distances, nearest and second
/// nearest, where there are any. A match without a ratio has r = 1. A match is set aside if a frame is not
/// finite, has no area or is more than 10 times longer than wide, or if one frame is a thousand times larger
/// than the other.
///
/// Failure: missing frames give `unsupported_input`. All left or all right points equal, or no usable frame,
/// give `degenerate`. The score is what keeping the match saves, theta - E: the reward of its descriptor and
/// of its kept neighbours; NaN for matches that were set aside. Iterations are the number of matches that
/// were dropped, plus 1.
///
/// Cost: O(N log N + N k) time, up to 24 N k bytes in the workspace.
///
/// Source: Collins, Mesejo and Bartoli, An analysis of errors in graph-based keypoint matching and proposed
/// solutions, ECCV 2014. The errors of pairs are those of Cho, Lee and Lee, ICCV 2009.
class GaimSelector : public SelectorWithOptions<GaimOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "gaim"; }

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
