#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "auto/evidence.h"
#include "auto/memory.h"
#include "corrsel/selectors/auto.h"

namespace corrsel::core {

/// Finds the fundamental matrix that chance explains the least.
///
/// Algorithm: candidates come from the cheapest source to the dearest one. Each is refined on all matches.
///  1. That of the parallax test (parallax.h), where there is parallax.
///  2. Uniform samples of the local set: in the order of support, the best matches lie on one surface. With
///     descriptors, a candidate of the parallax test that agrees with 95 % of the local set makes this
///     unnecessary, and is only replaced by one that a quarter of the matches off the homography agrees with.
///     Repeated structure on a facade pulls the others.
///  3. Where no candidate is significant, or the local set has less than half as many matches as the
///     homography, neighbours do not agree: there are few matches, or depth jumps from point to point. Then
///     the homography and pairs of other matches give candidates (improveByParallax()). It need not be
///     significant, because it holds for a few matches that lie on a plane by chance. At last, samples are
///     drawn from all matches.
///
/// Cost: O(N) for each hypothesis: 300 for the local set, 1000 pairs, and hardHypotheses().
class FundamentalSearch {
 public:
  /// @param memory      with matches, order by support and local support, and inliers of the homography; must
  ///                    outlive the search, like all parameters
  /// @param homography  normalised; nullptr = none
  FundamentalSearch(const AutoOptions& options, AutoMemory& memory, Effort& effort,
                    const cv::Matx33d* homography)
      : options_(options), memory_(memory), effort_(effort), homography_(homography) {}

  /// @param of_parallax  matrix of the parallax test, px; nullptr = none
  void run(const cv::Matx33d* of_parallax);

  /// Found, model and confidence.
  const FundamentalEvidence& best() const { return best_; }

 private:
  void searchLocalSet();
  void searchBesideHomography();
  void searchAll();
  bool search(const AutoMemory::Rows& rows, int hypotheses, double confidence, cv::Matx33d& model);
  bool refine(const cv::Matx33d& normalized, cv::Matx33d& model);
  void take(const cv::Matx33d& model);
  double agreeingShare(const cv::Matx33d& model, const AutoMemory::Mask& mask, std::uint8_t value);

  const AutoOptions& options_;
  AutoMemory& memory_;
  Effort& effort_;
  const cv::Matx33d* homography_;
  FundamentalEvidence best_;
};

}  // namespace corrsel::core
