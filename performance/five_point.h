#pragma once

#include <cstddef>

#include "kernels/kernels.h"
#include "measurement.h"

namespace corrsel::performance {

/// core::essentialsFromFive() for `n` samples of exact rays at one kernel level: with n = 1000, milliseconds
/// are microseconds per sample. The bytes of the solutions are compared in place of a mask.
Method fivePoint(core::KernelLevel level, std::size_t n, bool same_outcome);

}  // namespace corrsel::performance
