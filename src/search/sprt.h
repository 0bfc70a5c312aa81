#pragma once

#include <cstddef>

#include "kernels/kernels.h"

namespace corrsel::core {

/// Initial values of the test, before any model has been tested.
struct SprtConstants {
  double epsilon;            ///< smallest inlier ratio of a model that must be found
  double delta;              ///< probability that a match agrees with a bad model
  double model_time;         ///< time to draw, check and solve a sample, in verifications of one match (t_M)
  double models_per_sample;  ///< m_S
};

/// Wald's sequential probability ratio test (SPRT) on the matches of a model.
///
/// Idea: a bad model agrees with a match with probability delta, a good one with probability epsilon. A
/// few matches usually suffice to reject a bad model.
///
/// Algorithm: the likelihood ratio of "bad" to "good" is multiplied match by match. The model is rejected
/// as soon as the ratio exceeds A, the fixed point of
///   A = K + ln A, K = t_M C / m_S + 1,
///   C = (1-delta) ln((1-delta)/(1-epsilon)) + delta ln(delta/epsilon).
/// A good model is rejected with a probability of at most 1/A; for this reason A is at least 8 here. epsilon
/// rises with the best model found, and delta follows the rejected models.
///
/// Source: Matas and Chum, ICCV 2005; Raguram et al., PAMI 2013.
class Sprt {
 public:
  /// @param sample_share  sample size over number of matches; this share agrees with any model and must not
  ///                      count for delta
  explicit Sprt(const SprtConstants& constants, double sample_share = 0);

  /// Sets the fields of a rule that describe the test.
  void apply(ScoreRule& rule) const;

  /// Updates delta with a rejected model. @return true if the test has changed
  bool addRejected(const ModelScore& score);

  /// Updates epsilon with the inlier ratio of a new best model. @return true if the test has changed
  bool addBest(double inlier_ratio);

  /// Largest probability that a good model is rejected: 1/A.
  double loss() const { return 1.0 / decision_; }

 private:
  void design();

  SprtConstants constants_;
  double sample_share_, epsilon_, delta_, decision_ = 8;
  double log_consistent_ = 0, log_inconsistent_ = 0, log_decision_ = 0;
  std::size_t rejected_ = 0, seen_ = 0, agreed_ = 0;
};

}  // namespace corrsel::core
