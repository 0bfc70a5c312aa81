#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "search/model.h"
#include "search/verifier.h"

namespace corrsel::core {

/// Compares hypotheses by a score that cannot be given up early, such as a likelihood. Only hypotheses whose
/// cost by the verifier is near the lowest one get it. Keeps its memory between searches.
class SecondScore {
 public:
  virtual ~SecondScore() = default;

  /// Begins a search. Both must outlive it.
  virtual void start(const Model& model, const Verifier& verifier) = 0;

  /// The cost by the verifier from which on a hypothesis is rejected.
  virtual std::int64_t limit(const Candidate& best) const = 0;

  /// Whether the hypothesis is the best one by the second score.
  virtual bool isBest(const cv::Matx33d& hypothesis) = 0;

  /// Is told the new best model after its local optimisation, or without one.
  virtual void adopt(const Candidate& best, bool optimized) = 0;
};

}  // namespace corrsel::core
