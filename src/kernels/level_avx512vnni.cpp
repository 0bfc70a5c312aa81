#include "kernels/table.h"

namespace corrsel::core {

const Kernels kAvx512VnniKernels = kTable;

}  // namespace corrsel::core
