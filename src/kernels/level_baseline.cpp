#include "kernels/table.h"

namespace corrsel::core {

const Kernels kBaselineKernels = kTable;

}  // namespace corrsel::core
