#include "reference/error_mixture.h"

#include <cmath>

namespace corrsel::core {

MixtureFit fitMixture(const float* squared_errors, std::size_t count, const ErrorMixture& mixture,
                      std::vector<double>& densities) {
  constexpr int kSteps = 3;
  constexpr double kRootTwoPi = 2.50662827463100050242;
  constexpr double kFar = -50;  // exponent of a match at 10 sigma
  const double exponent = -0.5 / (mixture.sigma * mixture.sigma);
  const double peak = std::pow(kRootTwoPi * mixture.sigma, -mixture.dimensions);
  const double uniform = 1 / mixture.range;
  densities.resize(count);
  std::size_t near = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double power = exponent * static_cast<double>(squared_errors[i]);
    if (power > kFar) densities[near++] = peak * std::exp(power);
  }
  double share = 0.5;
  for (int step = 0; step < kSteps; ++step) {
    const double outlier = (1 - share) * uniform;
    double sum = 0;
    for (std::size_t k = 0; k < near; ++k) sum += share * densities[k] / (share * densities[k] + outlier);
    share = sum / static_cast<double>(count);
  }
  const double outlier = (1 - share) * uniform;
  double cost = near < count ? -static_cast<double>(count - near) * std::log(outlier) : 0.0;
  for (std::size_t k = 0; k < near; ++k) cost -= std::log(share * densities[k] + outlier);
  return {share, cost};
}

}  // namespace corrsel::core
