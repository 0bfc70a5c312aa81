#include "selectors/parts/otsu.h"

#include <algorithm>

namespace corrsel::core {
namespace {

/// Between-class variance for a lower class of weight w in (0, 1) and first moment mu; total mean mu_total.
double betweenClassVariance(double w, double mu, double mu_total) {
  const double difference = mu_total * w - mu;
  return difference * difference / (w * (1.0 - w));
}

}  // namespace

std::optional<double> otsuThreshold(const std::vector<double>& values, double low, double high, int bins) {
  if (values.size() < 2 || !(high > low)) return std::nullopt;
  std::vector<std::size_t> histogram(static_cast<std::size_t>(bins), 0);
  const double scale = bins / (high - low);
  for (const double value : values) {
    const int bin = std::clamp(static_cast<int>((value - low) * scale), 0, bins - 1);
    ++histogram[static_cast<std::size_t>(bin)];
  }
  const double n = static_cast<double>(values.size());
  double total = 0;
  for (int i = 0; i < bins; ++i) total += i * static_cast<double>(histogram[static_cast<std::size_t>(i)]);
  double best = -1, weight = 0, moment = 0;
  std::optional<double> threshold;
  for (int i = 0; i + 1 < bins; ++i) {
    const double count = static_cast<double>(histogram[static_cast<std::size_t>(i)]);
    weight += count;
    moment += i * count;
    if (count == 0 || weight == n) continue;
    const double variance = betweenClassVariance(weight / n, moment / n, total / n);
    if (variance > best) {
      best = variance;
      threshold = low + (i + 1) / scale;
    }
  }
  return threshold;
}

}  // namespace corrsel::core
