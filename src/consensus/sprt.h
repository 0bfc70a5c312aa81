#pragma once

#include <cstddef>

#include "kernels/kernels.h"

namespace corrsel::core {

/// What the test is designed with before anything has been learnt.
struct SprtConstants {
  double epsilon;            ///< smallest inlier ratio of a model that is to be found
  double delta;              ///< probability that a match agrees with a wrong model
  double model_time;         ///< time to draw, check and solve a sample, in verifications of one match (t_M)
  double models_per_sample;  ///< m_S
};

/// Wald's sequential probability ratio test on the matches of a model (Matas and Chum, ICCV 2005; Raguram et
/// al., PAMI 2013): the likelihood ratio of "wrong" (agrees with probability delta) to "right" (epsilon) is
/// multiplied match by match, and the model rejected once it exceeds A. A is the fixed point of A = K + ln A,
/// K = t_M C / m_S + 1, C = (1-delta) ln((1-delta)/(1-epsilon)) + delta ln(delta/epsilon); a right model is
/// rejected with a probability of at most 1/A, which is why A is never below 8 here.
///
/// epsilon rises with the best model found, delta follows the rejected ones.
class Sprt {
 public:
  /// @param sample_share  sample size over number of matches: that share agrees with any model and says
  /// nothing
  ///                      about delta
  explicit Sprt(const SprtConstants& constants, double sample_share = 0);

  /// Writes the test into a rule.
  void apply(ScoreRule& rule) const;

  /// Takes in a rejected model. @return true where the test has been designed anew
  bool addRejected(const ModelScore& score);

  /// Takes in the share of inliers of a new best model. @return true where the test has been designed anew
  bool addBest(double inlier_ratio);

  /// Probability that a right model is rejected, at most: 1/A.
  double loss() const { return 1.0 / decision_; }

 private:
  void design();

  SprtConstants constants_;
  double sample_share_, epsilon_, delta_, decision_ = 8;
  double log_consistent_ = 0, log_inconsistent_ = 0, log_decision_ = 0;
  std::size_t rejected_ = 0, seen_ = 0, agreed_ = 0;
};

}  // namespace corrsel::core
