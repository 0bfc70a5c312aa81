#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace corrsel::core {

/// Decides when enough samples have been drawn: once the probability of having missed an all-inlier sample of
/// the best model so far, or of having lost the model made from it to the SPRT, is below 1 - confidence.
///
/// Every sample counts, also those that the sample check has refused: an all-inlier sample passes it.
/// ln(1 - confidence) >= sum over the SPRT's designs d of k_d ln(1 - P (1 - loss_d)), P = probability of an
/// all-inlier sample without replacement, k_d = samples drawn under design d (Matas and Chum, ICCV 2005, Eq.
/// 15).
class StoppingRule {
 public:
  /// @param confidence  in [0, 1]; 1 = never stop
  StoppingRule(double confidence, std::size_t matches, int sample_size);

  /// The SPRT has been designed anew after `drawn` samples and loses right models with this probability from
  /// now on.
  void setLoss(double loss, std::uint64_t drawn);

  /// The best model agrees with `inliers` matches.
  void setInliers(std::size_t inliers);

  /// PROSAC's stop: `inliers` of the best `pool` matches agree, more than chance explains. Adds to
  /// setInliers().
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
