#pragma once

// The kernels of one level, as the level_*.cpp files compile them.

#include "corrsel/kernels/kernels.h"
#include "residual_kernels.h"

namespace corrsel::core {

extern const Kernels kBaselineKernels, kAvx2Kernels, kAvx512Kernels;

namespace {

constexpr Kernels kTable = {
    {errorsKernel<Transfer>, errorsKernel<SymmetricTransfer>, errorsKernel<Sampson>},
    {scoreKernel<Transfer>, scoreKernel<SymmetricTransfer>, scoreKernel<Sampson>},
};

}  // namespace
}  // namespace corrsel::core
