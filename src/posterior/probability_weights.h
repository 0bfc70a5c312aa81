#pragma once

#include <array>
#include <cstddef>

namespace corrsel::core {

inline constexpr std::size_t kProbabilityTerms = 11;

/// Values or weights of: 1, fundamental matrix, d, e, d e, l, d l, ratio, agreement of others, what is left
/// over, other motion (MatchProbability has the meanings).
using ProbabilityTerms = std::array<double, kProbabilityTerms>;

/// Weights of the terms. scripts/maintenance/train_probability.sh writes them.
extern const ProbabilityTerms kWeightsWithModel, kWeightsWithoutModel;

}  // namespace corrsel::core
