#include "kernels/table.h"

namespace corrsel::core {

const Kernels kAvx512Kernels = kTable;

}  // namespace corrsel::core
