#pragma once

#include "programs/command_line.h"

namespace corrsel {

/// The arguments of the benchmark. Tests compare benchmark.launch and the documentation with this table.
const CommandLineTable& benchmarkArguments();

}  // namespace corrsel
