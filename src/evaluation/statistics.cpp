#include "corrsel/evaluation/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "corrsel/random.h"

namespace corrsel::core {

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return values.empty() ? std::numeric_limits<double>::quiet_NaN() : sum / static_cast<double>(values.size());
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  const double position = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(std::floor(position));
  const std::size_t above = std::min(below + 1, values.size() - 1);
  const double share = position - static_cast<double>(below);
  if (share == 0 || values[below] == values[above]) return values[below];  // also where they are infinite
  return values[below] + share * (values[above] - values[below]);
}

Interval bootstrapMean(const std::vector<double>& values, std::uint64_t seed, int resamples) {
  if (values.size() < 2) return {mean(values), mean(values)};
  Random random(seed);
  std::vector<double> means(static_cast<std::size_t>(resamples));
  for (double& resampled : means) {
    double sum = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      sum += values[random.index(static_cast<std::uint32_t>(values.size()))];
    }
    resampled = sum / static_cast<double>(values.size());
  }
  return {quantile(means, 0.025), quantile(means, 0.975)};
}

}  // namespace corrsel::core
