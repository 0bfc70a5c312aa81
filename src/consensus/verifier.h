#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>

#include "consensus/sprt.h"
#include "geometry/normalization.h"
#include "kernels/kernels.h"

namespace corrsel::core {

/// A model and what it was judged by.
struct Candidate {
  cv::Matx33d model = cv::Matx33d::zeros();
  std::int64_t cost = std::numeric_limits<std::int64_t>::max();  ///< lower is better; see ScoreRule
  std::size_t inliers = 0;

  bool exists() const { return cost != std::numeric_limits<std::int64_t>::max(); }
};

/// Judges models by the matches, which must stand in random order: every stretch of them then is a fair
/// sample. A model is given up once its cost has reached the limit, or once the matches seen so far leave it
/// a chance of at most 1e-12 to stay below it (bail-out test, Capel, BMVC 2005, with Hoeffding's inequality
/// for the bound).
class Verifier {
 public:
  /// @param matches    must outlive the verifier
  /// @param threshold  normalised
  /// @param msac       truncated squared errors (Torr and Zisserman, CVIU 2000), else the number of inliers
  Verifier(const NormalizedMatches& matches, Residual residual, double threshold, bool msac);

  const NormalizedMatches& matches() const { return matches_; }
  Residual residual() const { return residual_; }
  float squaredThreshold() const { return rule_.squared_threshold; }

  /// Scores the model, giving up (score.rejected) once its cost cannot, or almost surely will not, be below
  /// `limit`. O(matches seen).
  ModelScore score(const cv::Matx33d& model, std::int64_t limit) const;

  /// The same after the test, which takes up where the last one ended. Symmetric transfer errors are tested
  /// one way.
  ModelScore test(const cv::Matx33d& model, std::int64_t limit, const Sprt& sprt);

  /// Replaces `best` where the model is better. @return whether it was
  bool improve(const cv::Matx33d& model, Candidate& best) const;

 private:
  const NormalizedMatches& matches_;
  Residual residual_;
  ScoreRule rule_;
  std::size_t start_ = 0;
};

}  // namespace corrsel::core
