#pragma once

#include <string>

#include "corrsel/confidence.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct PoseOptions : ConfidenceOptions {
  PoseOptions();

  double threshold = 1.0;      ///< inlier threshold, px of the given images
  bool adaptive = false;       ///< refine with a threshold that follows the noise
  bool covariance = true;      ///< compute the covariance and leave agreements by chance out of the fit
  int max_iterations = 0;      ///< samples at most; 0 = 20000
  double confidence = 0.9999;  ///< probability of having drawn an all-inlier sample at which the search stops
  int seed = 0;                ///< of the samples
  double max_seconds = 0;      ///< time limit, s; 0 = none
  void visit(OptionVisitor& visitor) const override;
};

/// Finds the relative pose of two calibrated cameras, its covariance, and what motion the matches show.
///
/// Idea: with known cameras five matches determine the geometry, planes are no special case, and the answer
/// is what a robot needs. A pose is worth little without an uncertainty that is true, and a translation must
/// not be reported where the matches show none.
///
/// Algorithm: one match per point takes part (src/calibrated/search_set.h). The search of src/search/search.h
/// draws samples of five matches by PROSAC and scores essential matrices by the tangent Sampson error
/// (src/search/essential_model.h). Where fewer than 250 matches agree, a second search begins with those that
/// have local support. The best pose is refined by the Geman-McClure loss over the matches that agree, lie in
/// front of both cameras and do not agree by chance (src/calibrated/pose_refinement.h); where chance
/// agreements matter, over those with local support only. The verdict (src/calibrated/verdict.h) decides
/// whether they show a translation. The mask holds all matches that agree with the pose to `threshold` and
/// lie in front, or with the rotation to 1.5 times `threshold`.
///
/// What is known of the motion (Correspondences::prior) the pose keeps to exactly, and its covariance is 0 in
/// the known directions. With a known rotation samples have two matches, with a known vertical three
/// (src/search/prior_models.h), and a plane has one pose. With a known rig nothing is searched: matches are
/// judged by its pose, and the motion is always `general`.
///
/// What is believed of the motion (Correspondences::guess) is one hypothesis of the search, unless there is a
/// prior (src/calibrated/guess_search.h). It is refined without regard to the guess. If the refined rotation
/// agrees with the guessed one, a search of at most 2000 samples begins with it, with a confidence of at most
/// 0.95. Its answer is taken if it still agrees with the guess; otherwise the answer is that without a guess,
/// bit for bit unless max_seconds ends the search. Selection::guess tells whether the rotation of the answer
/// agrees with the guess within both uncertainties.
///
/// Input: coordinates and both cameras (Correspondences::left_camera, right_camera). Images need not be
/// rectified. Descriptor distances or probabilities are used where they are there. Matches without a ray are
/// ignored and counted.
///
/// Output: `pose`, see PoseResult. The model is E (general, planar) or R (rotation, rest), for unit rays. The
/// score is the negated squared error, px^2. `sigma` is the noise.
///
/// Failure: `unsupported_input` without cameras, `too_few` (fewer than 5 points; with a prior, fewer than 2
/// or 3), `degenerate` (all points of one image equal, without a prior those that agree on one line of an
/// image, or a pose that the matches do not determine),
/// `no_model` (fewer than 8 agree), `uncertain` (chance explains the agreement), `time_limit` (the best pose
/// so far).
///
/// Cost: O(samples + N).
///
/// Source: Nister, PAMI 2004 (five points); Terekhov and Larsson, ICCV 2023 (tangent Sampson error); the
/// verdicts and the treatment of chance agreements are this package's.
class PoseSelector : public SelectorWithOptions<PoseOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "pose"; }

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
