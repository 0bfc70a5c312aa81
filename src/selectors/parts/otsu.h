#pragma once

#include <optional>
#include <vector>

namespace corrsel::core {

/// Otsu's threshold (Otsu, IEEE Trans. SMC 1979): the value that splits the samples into two classes with the
/// largest between-class variance (mu_T w - mu)^2 / (w (1 - w)). Among equal splits the lowest wins.
/// @param values  finite samples in [low, high]
/// @param bins    histogram bins over [low, high], at least 1
/// @return t: the lower class is {v <= t}; nothing where all samples fall into one class.
/// O(N + bins).
std::optional<double> otsuThreshold(const std::vector<double>& values, double low, double high, int bins);

}  // namespace corrsel::core
