#include "kernels/table.h"

namespace corrsel::core {

const Kernels kPlainKernels = kTable;

}  // namespace corrsel::core
