#pragma once

#include <cstddef>

#include "kernels/lens_model.h"

namespace corrsel::core {

/// Which formulas a camera needs; the number of the kernel in UnprojectKernels.
enum class LensKind { kPlainPinhole, kPinhole, kRationalPinhole, kFisheye, kEquirectangular };
constexpr std::size_t kLensKinds = 5;

/// Rays of pixels.
struct UnprojectKernels {
  /// Writes the unit rays of n pixels, and their derivatives: nine columns, as in Rays. A pixel without a ray
  /// gets NaN in every column. A ray does not depend on the others.
  /// @return number of pixels without a ray
  std::size_t (*unproject[kLensKinds])(const LensModel& lens, const double* x, const double* y, std::size_t n,
                                       double* const* columns);
};

}  // namespace corrsel::core
