#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace corrsel::core {

/// Decides when enough samples have been drawn.
///
/// Idea: the search may stop once it is unlikely (probability below 1 - confidence) that no sample consisted
/// of inliers of the best model only, or that the SPRT rejected the model of every such sample.
///
/// Algorithm: stop when
///   ln(1 - confidence) >= sum_d k_d ln(1 - P (1 - loss_d)).
/// P is the probability of an all-inlier sample without replacement. k_d is the number of samples drawn while
/// the SPRT rejected right models with probability loss_d. Samples that the sample check refused count too,
/// because an all-inlier sample passes it.
///
/// Source: Matas and Chum, ICCV 2005, Eq. 15.
class StoppingRule {
 public:
  /// @param confidence  in [0, 1]; 1 = never stop
  StoppingRule(double confidence, std::size_t matches, int sample_size);

  /// Informs the rule that, after `drawn` samples, the SPRT rejects right models with probability `loss`.
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

}  // namespace corrsel::core
