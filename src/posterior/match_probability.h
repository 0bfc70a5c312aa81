#pragma once

#include <limits>
#include <vector>

#include "geometry/rays.h"
#include "posterior/answer_terms.h"

namespace corrsel::core {

/// The probability of a match with these terms.
double probabilityOf(const ProbabilityTerms& terms, const ProbabilityTerms& weights);

/// Computes the probability that each match is right, and the noise of the model's inliers.
///
/// Idea: What is known about a match is how near it is to the model, whether other matches support it
/// locally, and how much better it is than the second-best match. How much these count depends on the answer:
/// on its confidence, on how many locally supported matches around it the model leaves over, and on how many
/// matches without support agree with the model beyond chance.
///
/// Algorithm: The log odds of a match are a sum of terms, whose weights are constants
/// (probability_weights.h):
/// - d = (t^2 - r^2) / (t^2 + r^2), from 1 on the model to -1 far from it. r is the residual: the smaller
///   transfer error of a homography, the Sampson distance of a fundamental matrix. t is 5 px and 2.5 px;
/// - e = 1 for members of the extended local set (local_support.h), and d e;
/// - l = 10 / (10 + confidence), and d l;
/// - the ratio of the descriptor distances, from 0.5 to 1, and 0.8 where it is not known;
/// - for members of that set, (1 - d)^2 / 4 times the share of its members around the match, in one of 8 x 8
///   cells of the left image, that are farther than t from the model: the scene then has more than this model
///   there;
/// - for selected matches, (1 - d)^2 / 4: those off the model belong to another motion;
/// - for matches outside of that set, ln((k + 1) / (c + 1)), from -2 to 2. k is the number of those within t,
///   and c the number that chance explains, if those farther away are spread evenly over the image.
/// Without a model, e, l and the ratio count, with weights of their own.
///
/// docs/selectors.md states which matches count as right, and how well the probabilities are calibrated.
///
/// Failure: where nothing is selected, every probability is 0 and sigma is NaN.
///
/// Cost: O(N), 0.12 ms for 2000 matches. The memory is kept. Nothing depends on the order of the matches.
///
/// Source: own work; logistic regression.
class MatchProbability {
 public:
  void compute(const AnsweredMatches& answered);

  /// Of the model's inliers per coordinate of their residual (noise_scale.h), px; NaN without a model.
  double sigma() const { return sigma_; }

  /// Per match, in [0, 1].
  const std::vector<float>& probability() const { return probability_; }

 private:
  double sigma_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> errors_;  // squared, px^2
  RayMatches rays_;
  std::vector<float> probability_;
};

}  // namespace corrsel::core
