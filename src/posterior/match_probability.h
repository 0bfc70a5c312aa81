#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "auto/local_support.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// Matches with an answer about them. All per-match values are in one order.
struct AnsweredMatches {
  const Correspondences& matches;  ///< finite coordinates
  const LocalSupport& support;     ///< of these matches
  const std::vector<std::uint8_t>& mask;
  ModelKind kind;
  cv::Matx33d model;  ///< px; valid if kind is not kNone
  double confidence;  ///< of the answer, -log10 units
};

/// Computes the probability that each match is right, and the noise of the model's inliers.
///
/// Idea: What is known about a match is how near it is to the model, whether other matches support it
/// locally, and how much better it is than the second-best match. How much these count depends on the answer:
/// on its confidence, on how many locally supported matches the model leaves over, and on how many matches
/// without support agree with it beyond chance.
///
/// Algorithm: The log odds of a match are a sum of terms, whose weights are constants
/// (match_probability.cpp):
/// - d = (t^2 - r^2) / (t^2 + r^2), from 1 on the model to -1 far from it. r is the residual: the smaller
///   transfer error of a homography, the Sampson distance of a fundamental matrix. t is the residual at which
///   a match is as often right as wrong, apart from all other terms: 5 px and 2.5 px.
/// - e = 1 for members of the extended local set (local_support.h), and d e;
/// - l = 10 / (10 + confidence), and d l;
/// - the ratio of the descriptor distances, where it is known, otherwise 0.8;
/// - off the model, (1 - d) / 2 times the share of the extended local set that is farther than t from it, for
///   members of that set, because the scene then has more than this model;
/// - off the model, (1 - d) / 2 for selected matches, which belong to another motion;
/// - for matches outside of the extended local set, ln((k + 1) / (c + 1)), at most 2 and at least -2. k is
/// the
///   number of those within t, and c the number that chance explains, if those farther away are spread evenly
///   over the image.
/// Without a model, e, l and the ratio count, with weights of their own.
///
/// A match is right if its error is at most 5 px under a homography, and if its distance from the epipolar
/// line is at most some px: docs/selectors.md states how the weights were found and what they give.
///
/// Failure: where nothing is selected, every probability is 0 and sigma is NaN.
///
/// Cost: O(N), 0.1 ms for 2000 matches. The memory is kept. Nothing depends on the order of the matches.
///
/// Source: own work; logistic regression. A mixture of inliers and outliers whose shares are learnt for each
/// pair by EM predicts worse, because most matches within t are right whatever the density of outliers.
class MatchProbability {
 public:
  void compute(const AnsweredMatches& answered);

  /// Of the model's inliers per coordinate of their residual (noise_scale.h), px; NaN without a model.
  double sigma() const { return sigma_; }

  /// Per match, in [0, 1].
  const std::vector<float>& probability() const { return probability_; }

 private:
  void withModel(const AnsweredMatches& answered);
  void withoutModel(const AnsweredMatches& answered);

  double sigma_ = std::numeric_limits<double>::quiet_NaN();
  std::vector<double> errors_;  // squared, px^2
  std::vector<float> probability_;
};

}  // namespace corrsel::core
