#pragma once

#include <cstdint>
#include <vector>

namespace corrsel::core {

/// The sum of the weights of a filter of ScaleSpaceKernels.
inline constexpr int kWeightSum = 1 << 15;

/// Whole numbers in proportion to the values, with the sum kWeightSum. What rounding leaves goes to the
/// largest one.
/// @param values  not negative; the sum is positive
std::vector<int> wholeWeights(const std::vector<double>& values);

/// Pairs of weights, as ScaleSpaceKernels needs them: w[0] and w[1], w[2] and w[3] and so on, each weight
/// moved back by `shift` places. Weights outside are 0.
/// @param weights  each below 2^15
std::vector<std::int32_t> inPairs(const std::vector<int>& weights, int shift, int pairs);

}  // namespace corrsel::core
