#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "auto/leftover.h"
#include "auto/parallax.h"
#include "auto/plausibility.h"
#include "auto/thresholds.h"
#include "base/deadline.h"
#include "calibrated/pose_search.h"
#include "corrsel/correspondences.h"
#include "geometry/normalization.h"
#include "posterior/match_probability.h"
#include "search/frame_proposal.h"
#include "search/local_support.h"
#include "search/ordering.h"
#include "search/search.h"
#include "search/seed_growing.h"
#include "search/significance.h"
#include "search/support.h"
#include "selectors/parts/sequential_planes.h"

namespace corrsel::core {

/// Memory of the selector `auto` that is kept between calls, and the matches of the present one.
struct AutoMemory {
  using Rows = std::vector<std::uint32_t>;
  using Mask = std::vector<std::uint8_t>;

  /// Takes the matches of a call, in a random order that is independent of the order of the input.
  void assign(const Correspondences& input, const AutoOptions& options);

  std::size_t size() const { return rows.size(); }

  Thresholds thresholds;
  Ordering ordering;
  Rows rows;                // of the input, in random order: the order of everything below
  Correspondences matches;  // in this order
  NormalizedMatches normalized;
  Rows identity, best_first;  // all matches in this order, and by quality
  bool ranked = false;        // whether the quality is known
  Rows by_support;            // all matches by falling local support, then by quality
  DistinctSupport distinct;
  LocalSupport support;
  SignificanceTest significance;
  Leftover leftover;

  // The homography search.
  SeedGrowing growing;
  Rows seeds;
  FrameProposal frames;
  Rows rank, searched;
  Mask taken;
  std::vector<double> homography_errors;  // squared, px^2
  Mask homography_inliers;

  // What the models leave over.
  ParallaxTest parallax;
  Mask near_homography;                    // within twice the threshold
  Mask loose;                              // members of the local set outside of the homography
  std::vector<double> fundamental_errors;  // squared (tangent) Sampson distances, px^2
  PoseSearch pose_search;
  RayMatches rays;
  Mask near_fundamental;             // what it does not leave over
  std::vector<float> displacements;  // of the inliers of the homography, px

  // The answer.
  Plausibility plausibility;
  SequentialPlanes planes;
  Rows rest;
  Mask answer, core;
  MatchProbability probability;
};

/// What the searches of a call may use, and what they have cost so far.
struct Effort {
  /// Some of the time is kept for the answer, which takes longer for more matches, and local support gets
  /// half of the rest, so that some time remains for the search.
  Effort(double max_seconds, std::size_t matches, Workspace& workspace_of_call)
      : deadline(max_seconds), support_deadline(max_seconds), workspace(workspace_of_call) {
    constexpr double kSecondsPerMatch = 2e-7, kMaxShare = 0.3, kSupportShare = 0.5;
    const double answer = std::min(kMaxShare * max_seconds, kSecondsPerMatch * static_cast<double>(matches));
    deadline.reserve(answer);
    support_deadline.reserve(answer + kSupportShare * (max_seconds - answer));
  }

  void add(const SearchOutcome& outcome) {
    hypotheses += static_cast<std::uint64_t>(outcome.iterations);
    timed_out = timed_out || outcome.timed_out;
  }

  Deadline deadline, support_deadline;
  Workspace& workspace;
  std::uint64_t hypotheses = 0;
  bool timed_out = false;
};

}  // namespace corrsel::core
