#include "kernels/table.h"

namespace corrsel::core {

const Kernels kAvx2Kernels = kTable;

}  // namespace corrsel::core
