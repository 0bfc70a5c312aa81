#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "geometry/normalization.h"
#include "search/model.h"

namespace corrsel::core {

/// Decides when enough samples have been drawn.
///
/// Idea: the search may stop once it is unlikely (probability below 1 - confidence) that no sample consisted
/// of inliers of the best model only, or that the SPRT rejected the model of every such sample.
///
/// Algorithm: stop when
///   ln(1 - confidence) >= sum_d k_d ln(1 - P (1 - loss_d)).
/// P is the probability of an all-inlier sample without replacement. k_d is the number of samples drawn while
/// the SPRT rejected good models with probability loss_d. Samples that the sample check refused count too,
/// because an all-inlier sample passes it.
///
/// Source: Matas and Chum, ICCV 2005, Eq. 15.
class StoppingRule {
 public:
  /// @param confidence  in [0, 1]; 1 = never stop
  StoppingRule(double confidence, std::size_t matches, int sample_size);

  /// Informs the rule that, after `drawn` samples, the SPRT rejects good models with probability `loss`.
  void setLoss(double loss, std::uint64_t drawn);

  /// Informs the rule that the best model agrees with `inliers` matches.
  void setInliers(std::size_t inliers);

  /// Informs the rule that `inliers` of the best `pool` matches agree, more than by chance. PROSAC may stop
  /// on this condition in addition to that of setInliers().
  void setPrefix(std::size_t inliers, std::size_t pool);

  bool enough(std::uint64_t drawn) const { return static_cast<double>(drawn) >= needed_; }

 private:
  struct Epoch {
    double loss;
    std::uint64_t begin;  // samples drawn before it
  };
  double probability(std::size_t inliers, std::size_t pool) const;
  void update();

  double log_failure_;
  std::size_t matches_;
  int sample_size_;
  std::vector<Epoch> epochs_;
  double all_inliers_ = 0, prefix_ = 0;  // probabilities of an all-inlier sample
  double needed_;
};

/// A share of matches.
struct MatchShare {
  std::size_t inliers, pool;
};

/// Stopping condition of PROSAC: the prefix of the best matches with the largest share of inliers. Considered
/// are prefixes from which all samples so far were drawn, that are long enough for the kind of model, and
/// whose number of inliers is not explained by chance (inlier probability 5 %, confidence 95 %, normal
/// approximation of the binomial tail). O(N).
/// @param errors  squared errors of the matches under the best model
/// @param counts  whether a match counts; empty = all do
/// @param pool_of_all  the shortest prefix from which all samples were drawn
/// @return no inliers if there is no such prefix
MatchShare bestPrefix(const std::vector<std::uint32_t>& best_first, const std::vector<float>& errors,
                      float squared_threshold, const std::vector<std::uint8_t>& counts,
                      const ModelTraits& model, std::uint32_t pool_of_all);

/// The smallest number that samplesForMinSignificance() returns.
inline constexpr double kMinSignificanceSamples = 1e4;

/// Number of samples after which a further search cannot gain anything: the smallest support that chance
/// does not explain, if all its matches lay within a pixel of the model, would have been drawn. Matters
/// where there are few matches, since their smallest significant support is a large share of them.
double samplesForMinSignificance(const NormalizedMatches& matches, const Model& model, double confidence);

/// Inlier ratio for which the SPRT is designed. The search can find models down to the inlier ratio at which
/// as many uniform samples as it may draw contain one without an outlier with a probability of 99.9 %. The
/// model of a noisy sample agrees with about three of ten inliers.
/// @param finds_rarer  whether rarer models are found, as if a million samples were drawn at least
double minTestedRatio(int max_iterations, bool finds_rarer, int sample_size);

}  // namespace corrsel::core
