#pragma once

#include <cstdint>
#include <vector>

namespace corrsel::core {

/// Mean; NaN for no values.
double mean(const std::vector<double>& values);

/// Linearly interpolated quantile, q in [0, 1]; q = 0.5 is the median. NaN for no values, +Inf above a finite
/// value where the next one is infinite. O(N log N).
double quantile(std::vector<double> values, double q);

struct Interval {
  double low, high;
};

/// Resamples and seed of the intervals of a run and of its report.
inline constexpr int kBootstrapResamples = 2000;
inline constexpr std::uint64_t kBootstrapSeed = 0;

/// 95 % percentile bootstrap interval of the mean (B. Efron, Bootstrap methods: another look at the
/// jackknife, Annals of Statistics 1979): the 2.5 % and the 97.5 % quantile of the means of `resamples`
/// samples, which are drawn from the values with replacement. The same values in the same order give the same
/// interval. With one value both bounds are that value, without any they are NaN. This is the only definition
/// of the interval: the report obtains its intervals from the Python binding of it.
/// O(resamples * N).
Interval bootstrapMean(const std::vector<double>& values, std::uint64_t seed,
                       int resamples = kBootstrapResamples);

}  // namespace corrsel::core
