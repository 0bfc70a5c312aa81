#pragma once

#include <cstddef>
#include <vector>

namespace corrsel::core {

/// The mixture of MLESAC: errors of inliers are normal, those of outliers uniform.
struct ErrorMixture {
  double sigma;    ///< standard deviation of an inlier in each dimension, in the unit of the errors
  double range;    ///< size of the region in which an outlier may lie: a length for D = 1, an area for D = 2
  int dimensions;  ///< D of the error: 1 for a distance from a line, 2 for a distance between points
};

/// The likelihood of a model by MLESAC.
struct MixtureFit {
  double right_share;  ///< g after the EM steps
  double cost;         ///< -sum of ln p_i; lower is better
};

/// Estimates the share of inliers by expectation maximisation, and the likelihood of the errors.
///
/// Algorithm: p_i = g f_i + (1 - g) / range, f_i = exp(-e_i^2 / (2 sigma^2)) / (sqrt(2 pi) sigma)^D. From g =
/// 1/2, three steps g <- mean of g f_i / p_i. Beyond 10 sigma f_i is taken as 0, because it changes nothing
/// there; these matches are only counted.
///
/// Cost: O(N), and an exponential function and a logarithm for every match within 10 sigma.
///
/// Source: Torr and Zisserman, CVIU 2000.
/// @param squared_errors  may be infinite
/// @param densities       memory
/// @pre count > 0
MixtureFit fitMixture(const float* squared_errors, std::size_t count, const ErrorMixture& mixture,
                      std::vector<double>& densities);

}  // namespace corrsel::core
