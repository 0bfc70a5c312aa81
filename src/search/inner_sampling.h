#pragma once

#include <cstdint>
#include <vector>

#include "corrsel/random.h"
#include "search/model.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Makes right models of hypotheses whose samples hold an outlier or two: LO-RANSAC's inner samples.
///
/// Idea: among few inliers, samples with one outlier are far more frequent than samples without one (of 500
/// matches with 20 % of inliers, one sample of seven in 2800 beside one in 80000), and with two outliers
/// again. Their hypotheses are wrong, but agree with more inliers than other wrong ones do. A sample of the
/// matches that agree is then likely to hold inliers only.
///
/// Algorithm: of every run of hypotheses, the one with the lowest cost gets 30 samples from the matches
/// within 1.5 times its threshold. What lowers the cost is refined. A run is 100 iterations, or N / 10 where
/// that is more, so that the inner samples stay a small part of the time.
///
/// Cost: O(N) and 30 times solving and verifying for each run.
///
/// Source: Chum, Matas and Kittler, DAGM 2003. There, each new best model gets inner samples. Here the best
/// ones of all runs do, because among few inliers the best model so far is mostly one of chance.
class InnerSampling {
 public:
  /// Begins a search. Both must outlive it.
  void start(const Model& model, const Verifier& verifier, std::uint64_t seed);

  /// The cost from which on a hypothesis is of no use to this run.
  std::int64_t limit() const { return leader_.cost; }

  /// Takes a hypothesis whose cost is below the limit.
  void offer(const Candidate& hypothesis) { leader_ = hypothesis; }

  /// Counts one more iteration of the search. @return whether a run has ended that has a hypothesis
  bool endsRun();

  /// Draws the inner samples of the run that has ended, and begins the next run.
  /// @param best  replaced by the best of their models if that is better
  /// @return whether it was replaced
  bool improve(Candidate& best);

  /// The matches from which the model of improve() was made.
  const std::uint32_t* sample() const { return sample_; }

 private:
  void tryOne(Candidate& reached);

  const Model* model_ = nullptr;
  const Verifier* verifier_ = nullptr;
  Random random_;
  Candidate leader_;
  std::size_t run_ = 0, in_run_ = 0;
  std::uint32_t sample_[Model::kMaxSample] = {};
  std::vector<float> errors_;
  std::vector<std::uint32_t> agreeing_;
};

}  // namespace corrsel::core
