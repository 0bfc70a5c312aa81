#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>

#include "geometry/normalization.h"
#include "kernels/kernels.h"
#include "search/sprt.h"
#include "search/support.h"

namespace corrsel::core {

/// A model and its score.
struct Candidate {
  cv::Matx33d model = cv::Matx33d::zeros();
  std::int64_t cost = std::numeric_limits<std::int64_t>::max();  ///< lower is better; see ScoreRule
  std::size_t inliers = 0;                                       ///< all matches within the threshold
  std::size_t distinct = 0;  ///< those that count; the same number, unless the verifier counts points once

  bool exists() const { return cost != std::numeric_limits<std::int64_t>::max(); }
};

/// Scores models by the matches, which must be in random order, so that any run of consecutive matches is a
/// fair sample.
///
/// Algorithm: a model is given up once its cost has reached the limit, or once its probability of staying
/// below the limit, given the matches seen so far, is at most 1e-12 by Hoeffding's inequality (bail-out
/// test). Where every point counts once, an inlier that does not count has the cost of an outlier. The cost
/// of all inliers is a lower bound of that of the distinct ones, so the tests above come first, and few
/// models reach the count of points.
///
/// Source: Capel, BMVC 2005 (bail-out test).
class Verifier {
 public:
  /// @param matches    must outlive the verifier
  /// @param threshold  normalised
  /// @param msac       truncated squared errors (Torr and Zisserman, CVIU 2000), else the number of inliers
  /// @param distinct   the groups of equal points of these matches, so that every point counts once; must
  ///                   outlive the verifier, which uses its memory. nullptr = all inliers count
  Verifier(const NormalizedMatches& matches, Residual residual, double threshold, bool msac,
           DistinctSupport* distinct = nullptr);

  const NormalizedMatches& matches() const { return matches_; }
  Residual residual() const { return residual_; }
  float squaredThreshold() const { return rule_.squared_threshold; }

  /// Scores the model. Gives up (score.rejected) once its cost cannot be, or almost certainly will not be,
  /// below `limit`. O(matches seen).
  ModelScore score(const cv::Matx33d& model, std::int64_t limit) const;

  /// Runs the SPRT first, beginning with the match at which the previous test ended, and then scores as
  /// above. For symmetric transfer errors the test uses one direction only. The SPRT counts all inliers.
  ModelScore test(const cv::Matx33d& model, std::int64_t limit, const Sprt& sprt);

  /// Replaces `best` if the model is better. @return whether it was
  bool improve(const cv::Matx33d& model, Candidate& best) const;

 private:
  /// Takes the inliers that do not count out of the score of a model that has been scored in full.
  ModelScore countOnce(const cv::Matx33d& model, std::int64_t limit, ModelScore score) const;

  const NormalizedMatches& matches_;
  Residual residual_;
  ScoreRule rule_;
  DistinctSupport* distinct_;
  std::size_t start_ = 0;
};

}  // namespace corrsel::core
