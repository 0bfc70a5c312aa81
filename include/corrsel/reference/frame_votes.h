#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct FrameVotesOptions : ConfidenceOptions {
  enum class Rule : std::uint8_t { kDensity, kComponents };
  enum class Maps : std::uint8_t { kFrames, kTranslation };

  Rule rule = Rule::kDensity;  ///< density of votes, or clusters of matches, see the class
  Maps maps = Maps::kFrames;   ///< local maps: from the frames, or the translation of each match
  int k = 63;                  ///< neighbours of a match
  double sigma = 2;            ///< density: errors that agree, % of the right image's diagonal
  double share = 0.25;         ///< density: accepted above this share of the largest density; 0 = Otsu
  double cut = 15;             ///< components: largest error of an edge, px
  int min_members = 10;        ///< components: right points of a cluster at least

  void visit(OptionVisitor& visitor) const override;
};

/// Votes of neighbouring matches for local maps: the voting half of HVIV, and ACC with single linkage.
///
/// Idea: correct matches that are near each other have local maps which predict one another. Outliers
/// find hardly any neighbour that agrees.
///
/// Algorithm: each match i is joined to the `k` matches j with the nearest left points. d_ij is the mean of
/// the four errors with which the local maps of two matches predict the points of each other, in both
/// directions and in both images. Pairs that share a point (within 1 px) do not vote.
///  - Rule `density` (preset `hviv`): r_i is the mean over the neighbours of exp(-(d_ij / sigma)^2), the
///    density of the others in the space of transformations. Matches with r_i > share * max r are selected,
///    or those above Otsu's threshold if `share` is 0.
///  - Rule `components` (preset `acc`): matches joined by edges with d_ij <= cut form clusters. Those with at
///    least `min_members` distinct right points are selected.
///
/// What is the authors': HVIV (Chen, Lin and Chen, CVPR 2013) lets each match vote by the density of the
/// others in the space of homographies, and alternates with an inverted step that proposes new candidates for
/// the features of an image region. This step needs images and descriptors, which a selector does not have.
/// ACC (Cho, Lee and Lee, ICCV 2009) has this dissimilarity, to which it adds the appearance. It merges
/// clusters bottom-up by the mean of the k smallest dissimilarities between them. What is ours: the
/// neighbourhoods, single linkage, and all constants, because the papers' were not available.
///
/// Input: coordinates; the local affine frames of both features, or none with `maps` = translation; the size
/// of the right image for the rule `density`. A match is set aside if a frame is not finite, has no area or
/// is more than 10 times longer than wide, or if one frame is a thousand times larger than the other.
///
/// Output: with the rule `components`, `group` has the number of the cluster, if any cluster is selected; the
/// largest cluster is the one with most distinct right points.
///
/// Presets: `hviv` is the default; `acc` has the rule `components` with 32 neighbours.
///
/// Failure: a missing column or size gives `unsupported_input`. All left or all right points equal, or no
/// usable frame, give `degenerate`. Nothing is selected where no two matches agree. The score is r_i / max r,
/// or the number of distinct right points of the cluster; NaN for matches that were set aside.
///
/// Cost: O(N log N + N k) time, 4 N k bytes in the workspace.
///
/// Source: see above.
class FrameVotesSelector : public SelectorWithOptions<FrameVotesOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "frame_votes"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
