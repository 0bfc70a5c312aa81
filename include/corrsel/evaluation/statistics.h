#pragma once

#include <cstdint>
#include <vector>

namespace corrsel::core {

/// Mean; NaN for no values.
double mean(const std::vector<double>& values);

/// Linearly interpolated quantile, q in [0, 1]; q = 0.5 is the median. NaN for no values. O(N log N).
double quantile(std::vector<double> values, double q);

struct Interval {
  double low, high;
};

/// 95 % percentile bootstrap interval of the mean (Efron 1979): `resamples` resamples, seeded, so that the
/// same values give the same interval. One value: the value itself; none: NaN. O(resamples * N).
Interval bootstrapMean(const std::vector<double>& values, std::uint64_t seed, int resamples = 2000);

}  // namespace corrsel::core
