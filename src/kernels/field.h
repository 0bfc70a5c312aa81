#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// Points per group of the field kernels: their columns are as long as a multiple of it.
constexpr std::size_t kFieldGroup = 8;

/// K ~ L L^T, column by column, behind the two columns of the field samples u and v.
struct FieldFactor {
  const double* columns;  ///< column j starts at columns + j * stride
  std::size_t stride;     ///< >= padded
  std::size_t rank;       ///< columns of L, without u and v
  std::size_t padded;     ///< points, rounded up to whole groups
};

/// Pivots of the next columns of a factor.
struct FieldPivots {
  std::size_t count;
  const double *x, *y;  ///< their points
  const double* rest;   ///< remainder of the diagonal at each pivot when it is processed, > 0
  const double* rows;   ///< row c of L starts at rows + c * row_stride and holds rank + c elements
  std::size_t row_stride;
};

/// p = e / (e + outlier) with e = exp(exponent * squared residual).
struct FieldPosteriorRule {
  double exponent, outlier;
  double min_posterior;  ///< smaller posteriors are stored as this
  double threshold;      ///< posteriors above it are counted
};

struct FieldPosteriorSums {
  double weighted = 0;  ///< sum of p * squared residual
  double sum = 0;       ///< sum of p
  double clamped = 0;   ///< sum of max(p, min_posterior)
  double accepted = 0;  ///< number of p > threshold
};

/// Vector fields on a factored kernel matrix, in double precision.
struct FieldKernels {
  /// Writes the next columns of the pivoted Cholesky factor of exp(-beta d^2) to `added`, at the factor's
  /// stride, and the remaining diagonal to `rest`. O(padded * count * rank). @return largest element of
  /// `rest`
  double (*factor)(const double* x, const double* y, double beta, const FieldPivots& pivots,
                   const FieldFactor& factor, double* added, double* rest);

  /// gram[j * m + k] = sum of weight * column j * column k, j <= k < m = rank + 2; below the diagonal it is
  /// undefined. `lanes`: scratch for m * m * kFieldGroup numbers. O(padded * m^2 / 2).
  void (*gram)(const FieldFactor& factor, const double* weight, double* lanes, double* gram);

  /// squared = |(u, v) - L w|^2, w row-major rank x 2. @return sum of weight * squared.
  double (*residuals)(const FieldFactor& factor, const double* coefficients, const double* weight,
                      double* squared);

  /// Posteriors of `size` points; the rest of the last group is set to 0.
  FieldPosteriorSums (*posteriors)(const FieldPosteriorRule& rule, const double* squared, std::size_t size,
                                   double* posterior);
};

}  // namespace corrsel::core
