#pragma once

#include <string>

#include "corrsel/confidence.h"
#include "corrsel/options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct AutoOptions : ConfidenceOptions {
  enum class Model : std::uint8_t { kAuto, kHomography, kFundamental };

  AutoOptions();

  Model model = Model::kAuto;        ///< model to which the answer is restricted
  double threshold = 0;              ///< inlier threshold of a homography, px; 0 = by the noise
  double fundamental_threshold = 0;  ///< inlier threshold of a fundamental matrix, px; 0 = by the noise
  int hard_search = 2000;            ///< hypotheses where nothing else has found a model; 0 = none
  int seed = 0;                      ///< of the samplers
  int threads = 1;                   ///< that may be used
  double max_seconds = 0;            ///< time limit, s; 0 = none
  void visit(OptionVisitor& visitor) const override;
};

/// Finds out by itself what kind of scene the matches show, selects accordingly, and reports how sure it is.
///
/// Idea: two facts carry it. First, one match fixes a local map, so that every match is a hypothesis of its
/// own, and the number of other matches that it predicts decides whether it is an inlier. No sample of four
/// inliers has to be drawn, which is hopeless among few of them. Second, which model a scene needs shows
/// in what a model leaves over: matches with local support that it does not explain.
///
/// Algorithm:
///  1. Evidence (src/auto/gathering.h). Local support (src/search/local_support.h) gives the local set L, the
///     extended local set L2, and a local map per match. The best homography H is found from these
///     (homography_search.h). Where the decision asks for it, it is tested whether the matches off H show
///     parallax (parallax.h), a fundamental matrix F is searched (fundamental_search.h), and it is tested
///     what a model leaves over of L (leftover.h).
///     With the cameras of both images, the pose is searched instead (pose.h): its essential matrix takes the
///     place of F, and the verdict about the motion that of the test of parallax.
///  2. Decision (decision.h). A table states which evidence leads to which scene and answer.
///  3. Answer (answer.h). Matches agree with H if the smaller one of their transfer errors in both images is
///     at most `threshold`. They agree with F if their Sampson distance is at most `fundamental_threshold`,
///     or twice that for members of L2, and if their surroundings make them plausible (plausibility.h). A
///     rigid scene includes the matches that agree with its dominant plane, H.
///     Where there are several motions, planes are searched among what the model leaves over
///     (sequential_planes.h), with hypotheses from L2, and L2 is selected, too.
///
/// Input: coordinates. Cameras, image sizes, descriptor distances or probabilities, and frames are used
/// where they exist.
///
/// Options: `threshold` and `fundamental_threshold` are the errors that the user allows, px. Where they are
/// 0, they follow the noise of the inliers (src/auto/thresholds.h). Below `min_confidence`, the best guess is
/// returned with the status `uncertain`. The decision takes a model for real from a confidence of 4. With
/// `max_seconds` the hard search is cut first. Local support uses `threads`.
///
/// Output: where there are several motions, `group` is 0 for the matches that agree with the returned model,
/// 1 and up for those of the planes that move in another way, and -1 for selected matches that only agree
/// with their surroundings. The score is the local support, the log likelihood ratio of a Poisson count. The
/// iterations are hypotheses. `scene` holds what was found, and the message says it in words. `sigma` and
/// `probability` are filled as addProbability() does. With cameras, `pose` holds what the selector `pose`
/// returns, whatever the scene is, and the model of a rigid scene is an essential matrix.
///
/// Presets: `h` and `f` restrict the answer to that model; `fast` does without the hard
/// search and the hypotheses of single frames, and with a quarter of the others.
///
/// Failure: `too_few` (fewer than 6 matches), `uncertain` (a best guess that chance explains), `no_model`
/// (nothing agrees with anything), `degenerate` (all points of one image are equal), `time_limit` (the best
/// answer so far).
///
/// Cost: O(N) for the local support and all steps after it, with about 10^6 operations at least; the hard
/// search adds O(hypotheses). Memory of some hundred bytes per match is kept between calls.
///
/// Source: this package. The support count is related to AdaLAM (Cavalli et al., ECCV 2020) and to fast
/// spatial matching (Philbin et al., CVPR 2007), the significance to Moisan and Stival, IJCV 2004.
class AutoSelector : public SelectorWithOptions<AutoOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "auto"; }
  Presets presets() const override;

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
