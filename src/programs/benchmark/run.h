#pragma once

#include <string>
#include <vector>

#include "programs/benchmark/front.h"

namespace corrsel {

/// The whole benchmark program: reads the arguments, runs the grid and writes a run's folder, see --help.
/// Errors are printed.
/// @param words  the command line without the program's name
/// @return exit code
int runBenchmark(const std::vector<std::string>& words, BenchmarkFront& front);

}  // namespace corrsel
