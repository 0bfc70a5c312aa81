#include "reference/error_mixture.h"

#include <Eigen/Core>
#include <cmath>

namespace corrsel::core {

MixtureFit fitMixture(const float* squared_errors, std::size_t count, const ErrorMixture& mixture,
                      std::vector<double>& densities) {
  constexpr int kSteps = 3;
  constexpr double kRootTwoPi = 2.50662827463100050242;
  constexpr double kFar = -50;  // exponent of a match at 10 sigma
  const double exponent = -0.5 / (mixture.sigma * mixture.sigma);
  // All densities are multiples of the normal density at 0.
  const double peak = std::pow(kRootTwoPi * mixture.sigma, -mixture.dimensions);
  const double uniform = 1 / (mixture.range * peak);
  densities.resize(count);
  std::size_t near = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double power = exponent * static_cast<double>(squared_errors[i]);
    densities[near] = power;
    near += power > kFar ? 1 : 0;
  }
  Eigen::Map<Eigen::ArrayXd> normal(densities.data(), static_cast<Eigen::Index>(near));
  normal = normal.exp();
  double share = 0.5;
  for (int step = 0; step < kSteps; ++step) {
    const double outlier = (1 - share) * uniform;
    share = (share * normal / (share * normal + outlier)).sum() / static_cast<double>(count);
  }
  const double outlier = (1 - share) * uniform;
  double cost = -static_cast<double>(count) * std::log(peak);
  if (near < count) cost -= static_cast<double>(count - near) * std::log(outlier);
  cost -= (share * normal + outlier).log().sum();
  return {share, cost};
}

}  // namespace corrsel::core
