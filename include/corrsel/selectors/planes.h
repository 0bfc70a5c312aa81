#pragma once

#include <string>

#include "corrsel/search/options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// The other parts of the search are those of UsacOptions.
struct PlanesOptions : SearchOptions {
  PlanesOptions();

  bool frames = true;          ///< use local affine frames where there are any, in place of samples
  int max_planes = 8;          ///< planes at most
  double relative_cut = 0.03;  ///< smallest confidence of a further plane, relative to that of the first one
  double widen = 3;            ///< inlier threshold over the threshold of the significance
  double min_threshold = 4;    ///< smallest inlier threshold, px
  double max_threshold = 10;   ///< largest inlier threshold, px
  void visit(OptionVisitor& visitor) const override;
  std::string missingInput(const Correspondences& matches) const {
    return missingFor(matches, ModelKind::kHomography);
  }
};

/// Finds planes one after another: sequential a contrario homographies.
///
/// Idea: a scene of several planes, or several things that move, is explained by several homographies. The
/// significance of a homography decides whether there is a further one, so their number need not be known.
///
/// Algorithm: the most significant homography of the matches that are left is found as by AcransacSelector
/// (search/significant_model.h). It comes from the frames of single matches where there are frames
/// (search/frame_hypotheses.h), otherwise from samples, by default local ones (search/local_proposal.h). The
/// planes end with the first homography whose confidence among the matches that are left is below 4, or below
/// `relative_cut` times that of the first plane. Otherwise the matches within t = `widen` e are taken out,
/// where e is the threshold at which the homography is the most significant, t at least `min_threshold` and
/// at most `max_threshold`. In the end, every match is selected whose error under one of the homographies is
/// at most that one's t. The error is the smaller one of both transfer errors.
///
/// Output: `group` has the number of the plane with the smallest error, among those that select the match, in
/// the order in which they were found. The model is the first plane's homography, and the confidence is its,
/// too. The score is the negated squared error under the plane of the group, or the smallest one of all
/// planes for rejected matches, px^2. Iterations are the hypotheses of all planes.
///
/// Input: coordinates. Frames, descriptor distances or probabilities, and the sizes of the images are used
/// where they exist.
///
/// Presets: `first` ends after the first plane.
///
/// Failure: `no_model` where no homography is significant, `too_few` (fewer than 4 matches), `degenerate` (no
/// valid sample), and `time_limit` with the planes found so far.
///
/// Cost: that of AcransacSelector with 1000 samples, or 60 frames, for each plane and for one more search.
///
/// Source: Vincent and Laganiere, ISPA 2001 (sequential RANSAC); Rabin, Delon, Gousseau and Moisan, 3DPVT
/// 2010 (a contrario, several objects); Bellavia et al., arXiv:2411.09484 (union of planes). Read of the
/// second: the abstract only.
class PlanesSelector : public SelectorWithOptions<PlanesOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "planes"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override {
    return options_.missingInput(matches);
  }
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
