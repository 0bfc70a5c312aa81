#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "base/deadline.h"
#include "corrsel/motion_guess.h"
#include "corrsel/pose_result.h"
#include "corrsel/workspace.h"
#include "geometry/normalization.h"
#include "geometry/rays.h"
#include "search/parameters.h"
#include "search/proposal.h"

namespace corrsel::core {

/// Among what the hypothesis of a guess is found.
struct GuessSearchInput {
  const NormalizedMatches& matches;              ///< with rays, in random order
  const RayMatches& rays;                        ///< of the same matches
  const std::vector<std::uint32_t>* best_first;  ///< by quality; nullptr = unknown
  Proposal& proposal;                            ///< of samples
};

/// Makes a hypothesis of a guess of the motion, an essential matrix that is refined without regard to the
/// guess.
///
/// Algorithm: the translation given, and translations from samples of two matches (search/prior_models.h),
/// compete under the guessed rotation, with a threshold that allows for twice its standard deviation. The
/// best one is refined in all directions while the threshold is halved down to the user's.
///
/// Cost: at most 1000 samples of two matches, and O(N) for every halving.
/// @param iterations  receives the number of hypotheses
/// @return nothing if no pose agrees with 8 matches, or if the rotation went far from the guessed one
std::optional<cv::Matx33d> hypothesisOfGuess(const MotionGuess& guess, const GuessSearchInput& input,
                                             const SearchParameters& parameters, const Deadline& deadline,
                                             Workspace& workspace, int& iterations);

/// Whether the rotation of a pose, or of the second pose of a plane, agrees with the guessed one: their
/// squared distance in units of the sum of the variance of the guess and the covariance of the pose (where it
/// is known) is at most 14.2, which a right guess exceeds in 0.27 % of cases (chi-squared with 3 degrees of
/// freedom).
bool agreesWithGuess(const PoseResult& pose, const MotionGuess& guess);

}  // namespace corrsel::core
