#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "base/deadline.h"
#include "calibrated/pose_refinement.h"
#include "calibrated/search_set.h"
#include "calibrated/verdict.h"
#include "corrsel/correspondences.h"
#include "corrsel/motion_guess.h"
#include "corrsel/pose_prior.h"
#include "corrsel/pose_result.h"
#include "corrsel/selection.h"
#include "corrsel/workspace.h"
#include "geometry/pose_fit.h"
#include "search/local_support.h"
#include "search/selecting.h"

namespace corrsel::core {

/// Matches agree with a rotation up to this many thresholds, because its error has two coordinates.
inline constexpr double kRotationWidth = 1.5;

/// How a pose is searched.
struct PoseParameters {
  double threshold = 1;    ///< px
  bool adaptive = false;   ///< refine with a threshold that follows the noise
  bool covariance = true;  ///< compute it, and leave agreements by chance out of the refinement
  double max_seconds = 0;  ///< for the message, s
  /// Per match, whether it has local support (LocalSupport::extended()), where that is known already.
  const std::vector<std::uint8_t>* supported = nullptr;
  std::optional<PosePrior> prior;  ///< what is known of the motion; that of the matches is not used
  /// What is believed of the motion; that of the matches is not used. Without a prior it is one hypothesis of
  /// the search. Where the answer does not agree with it, the answer is that without it.
  std::optional<MotionGuess> guess;
  SearchParameters search;
};

/// Searches for the relative pose of calibrated cameras, refines it, and decides what motion the matches
/// show. The pose keeps exactly to what is known of the motion, and its covariance is 0 in known directions.
/// The pose of a rig is not searched, and only the noise and the parallax are found out. Keeps its memory
/// between calls.
class PoseSearch {
 public:
  /// @param matches     with both cameras
  /// @param result      receives status, message, iterations and ignored matches where there is something to
  ///                    report, and the verdict about the guess
  /// @return the pose; nothing if the status is `too_few`, `degenerate` or `no_model`
  std::optional<PoseResult> find(const Correspondences& matches, const PoseParameters& parameters,
                                 const Deadline& deadline, Workspace& workspace, Selection& result);

  /// The rays of all matches; NaN where they do not exist.
  const RayMatches& rays() const { return input_.rays(); }

 private:
  std::optional<PoseResult> findByGuess(const Correspondences& matches, const PoseParameters& parameters,
                                        Proposal& proposal, const Deadline& deadline, Workspace& workspace,
                                        Selection& result);
  std::optional<PoseResult> answer(const Correspondences& matches, const PoseParameters& parameters,
                                   const SearchOutcome& outcome, Selection& result);
  PoseResult judgeRig(const PoseParameters& parameters);
  bool refine(const Correspondences& matches, const PoseParameters& parameters, Pose& pose);
  bool isOnLine(const Verdict& verdict, double threshold);
  SearchOutcome search(const Correspondences& matches, const PoseParameters& parameters,
                       const SearchParts& parts, const Deadline& deadline, Workspace& workspace);
  const std::vector<std::uint8_t>& supported(const Correspondences& matches,
                                             const std::vector<std::uint8_t>* known);
  std::vector<std::uint32_t> order() const;
  bool isSupported(const std::vector<std::uint8_t>& supported) const;
  double chanceShare() const;
  double noise(double threshold) const;
  void describe(const PoseParameters& parameters, const Verdict& verdict, PoseResult& found) const;
  double parallax(const Pose& pose, double threshold) const;

  SearchSet search_set_;
  SearchInput input_;
  PoseRefinement refinement_;
  MotionVerdict verdict_;
  RayMatches set_;             // the rays of the search set
  Correspondences supported_;  // the search set, for the local support
  std::vector<std::uint32_t> agreeing_;
  LocalSupport support_;
  bool support_known_ = false;
  std::vector<std::uint8_t> candidates_;  // per match of the search set: whether it has local support
  PoseFreedom freedom_;                   // of the pose under the prior
  double fitted_threshold_ = 0;           // of the last refinement, px
};

}  // namespace corrsel::core
