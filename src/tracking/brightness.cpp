#include "tracking/brightness.h"

#include <cmath>
#include <cstddef>

#include "corrsel/evaluation/statistics.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinValues = 20;
constexpr double kLargestGain = 4, kOutlier = 3, kBetter = 0.5, kSmall = 0.5;

std::vector<double> differences(const std::vector<double>& values, const std::vector<double>& expected,
                                const Brightness& map) {
  std::vector<double> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) result[i] = std::abs(map(values[i]) - expected[i]);
  return result;
}

/// Least squares of the values that differ by at most `limit`.
Brightness leastSquares(const std::vector<double>& values, const std::vector<double>& expected,
                        const std::vector<double>& differences, double limit) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (differences[i] > limit) continue;
    n += 1;
    x += values[i];
    y += expected[i];
    xx += values[i] * values[i];
    xy += values[i] * expected[i];
  }
  const double gain = (n * xy - x * y) / (n * xx - x * x);
  return {gain, (y - gain * x) / n};
}

}  // namespace

Brightness fitBrightness(const std::vector<double>& values, const std::vector<double>& expected,
                         const Brightness& current) {
  if (values.size() < kMinValues) return current;
  std::vector<double> off = differences(values, expected, current);
  const double before = quantile(off, 0.5);
  if (before < kSmall) return current;
  Brightness fit = current;
  for (int round = 0; round < 2; ++round) {
    fit = leastSquares(values, expected, off, kOutlier * quantile(off, 0.5));
    // Also false for NaN, where all values are equal.
    if (!(fit.gain >= 1 / kLargestGain && fit.gain <= kLargestGain)) return current;
    off = differences(values, expected, fit);
  }
  return quantile(off, 0.5) < kBetter * before ? fit : current;
}

}  // namespace corrsel::core
