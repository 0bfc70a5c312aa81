#pragma once

#include <cstdint>
#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct TlinkageOptions : ConfidenceOptions {
  enum class Preference : std::uint8_t { kSoft, kHard };

  ModelKind structure = ModelKind::kHomography;  ///< planes, or rigid motions: fundamental matrices
  double tau = 5;                                ///< inlier scale of a model, px
  Preference preference = Preference::kSoft;     ///< T-Linkage, or J-Linkage
  int min_cluster = 8;                           ///< distinct matches of a cluster at least
  int hypotheses_per_match = 6;                  ///< samples that are drawn
  int max_matches = 3000;                        ///< distinct matches at most
  int seed = 0;                                  ///< of the sampler
  double max_seconds = 30;                       ///< time limit, s; 0 = none

  void visit(OptionVisitor& visitor) const override;
};

/// T-Linkage: clusters of matches that prefer the same models.
///
/// Idea: each of several structures in a scene, planes or motions, has its own model. Matches of one
/// structure agree about which models of a random set are good. Clusters are merged as long as they still
/// agree, so that neither the number of structures nor their sizes need to be known.
///
/// Algorithm: `hypotheses_per_match` N samples are drawn: a match in turn, and others of its 8, 16 or 32
/// nearest matches in the space of both points. With the structure `homography`, a sample has four matches
/// and gives one homography, so that clusters are planes. With `fundamental`, it has seven and gives up to
/// three fundamental matrices, so that clusters are rigid motions. Drawing ends early where the models so far
/// have so many inliers that comparing them takes a fraction of a second. The preference of match i for
/// hypothesis h with the error r (transfer error, or Sampson distance) is exp(-r / tau) if r < 5 tau and else
/// 0; with the preference `hard` (J-Linkage) it is 1 if r < tau. The distance of two clusters is Tanimoto's,
///
///     1 - <p, q> / (|p|^2 + |q|^2 - <p, q>),
///
/// and a union prefers a hypothesis as much as the least of its parts does. The closest clusters are merged
/// as long as their distance is below 1. Matches of clusters with at least `min_cluster` distinct matches are
/// selected. Equal distances are resolved by the order of the coordinates.
///
/// Input: coordinates. Equal matches count once.
///
/// Output: `group` has the number of the cluster, if any cluster is selected. The score is the number of
/// distinct matches in the cluster; iterations are mergers.
///
/// Options: `structure` is not called `model`, because the benchmark sets options of that name by the ground
/// truth of the dataset, and homographies select better even where the truth is a fundamental matrix.
/// Sampson distances leave one coordinate free, so that fundamental matrices need a smaller `tau`.
///
/// Presets: `jlinkage`; `motions` has fundamental matrices, tau = 1 px and clusters of 14 matches.
///
/// Failure: fewer than 5 distinct matches, or 8 for fundamental matrices, give `too_few`, and more than
/// `max_matches` give `too_large`. If no sample determines a model, the status is `degenerate`. At
/// `max_seconds`, the clusters so far decide and the status is `time_limit`; before the first merger it is
/// `too_large`, and nothing is selected.
///
/// Cost: O(N^2 log N) time and 4 N^2 bytes in the workspace, apart from preferences, whose time and memory
/// grow with N times the sizes of the structures. It is meant for some hundreds to 3000 matches.
///
/// Source: Magri and Fusiello, CVPR 2014 (T-Linkage); Toldo and Fusiello, ECCV 2008 (J-Linkage). The sampler
/// is ours: theirs draws neighbours by a distance-dependent probability.
class TlinkageSelector : public SelectorWithOptions<TlinkageOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "tlinkage"; }
  Presets presets() const override;

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
