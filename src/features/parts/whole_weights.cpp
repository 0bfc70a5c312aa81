#include "features/parts/whole_weights.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace corrsel::core {

std::vector<int> wholeWeights(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  std::vector<int> weights;
  int rest = kWeightSum;
  for (const double value : values) {
    weights.push_back(static_cast<int>(std::lround(value / sum * kWeightSum)));
    rest -= weights.back();
  }
  *std::max_element(weights.begin(), weights.end()) += rest;
  return weights;
}

std::vector<std::int32_t> inPairs(const std::vector<int>& weights, int shift, int pairs) {
  std::vector<std::int32_t> result;
  const auto at = [&](int k) {
    return static_cast<std::uint32_t>(
        k >= 0 && k < static_cast<int>(weights.size()) ? weights[static_cast<std::size_t>(k)] : 0);
  };
  for (int j = 0; j < pairs; ++j) {
    result.push_back(static_cast<std::int32_t>(at(2 * j - shift) | at(2 * j + 1 - shift) << 16));
  }
  return result;
}

}  // namespace corrsel::core
