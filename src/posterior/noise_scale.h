#pragma once

#include <cstddef>
#include <vector>

namespace corrsel::core {

/// What is known about the residuals of a model before the scale of their noise is estimated.
struct ResidualKind {
  int dimensions = 2;  ///< of the residual: 2 for transfer errors, 1 for Sampson distances
  int parameters = 8;  ///< degrees of freedom of the fitted model: 8 for a homography, 7 for F
  double cut = 10;     ///< larger residuals are left out, px
  double background =
      0;  ///< expected outliers per px^dimensions (per px of |r| for 1), at least; 0 = unknown
};

/// Noise of the inliers of a model.
struct NoiseScale {
  double sigma;        ///< standard deviation of each coordinate of an inlier's residual, px; NaN = unknown
  double inliers = 0;  ///< expected number of them among the residuals within the cut
};

/// Estimates the scale of the noise of a model's inliers from the residuals of inliers and outliers.
///
/// Algorithm: The residuals within the cut are a mixture of inliers, whose coordinates are Gaussian, so that
/// their lengths have a Rayleigh (2 dimensions) or half-normal (1 dimension) distribution that ends at the
/// cut, and of outliers, which are uniform within the cut. The shares and the scale are found by EM on a
/// histogram. The step of the scale solves E[r^2 | r <= cut] = weighted mean of r^2, so that the cut does not
/// make it smaller. At last sigma^2 is multiplied by d k / (d k - p) for k inliers of d dimensions and
/// p parameters, because a fit to its own inliers has residuals that are too small.
///
/// The uniform part also takes up inliers with gross errors: sigma is the noise of the core.
///
/// Output: sigma in [0.1 px, cut].
///
/// Failure: sigma is NaN where d k does not exceed p.
///
/// Cost: O(N), about 10 ns per residual, and 20 to 60 us for the histogram. The result does not depend on the
/// order of the residuals, bit for bit.
///
/// Source: EM for a truncated Gaussian beside a uniform background; that a scale must be corrected for the
/// cut and for the parameters: Edstedt, Less Biased Noise Scale Estimation, arXiv 2503.13433.
///
/// @param squared_residuals  px^2; infinite and NaN ones are outliers beyond the cut
/// @pre kind.cut >= 0.1, kind.dimensions is 1 or 2
NoiseScale estimateNoiseScale(const std::vector<double>& squared_residuals, const ResidualKind& kind);

}  // namespace corrsel::core
