#pragma once

#include <string>
#include <vector>

namespace corrsel {

/// The whole program: reads the arguments, extracts, matches, merges and verifies what they ask for, and
/// reports. Errors are printed.
/// @param words  the command line without the program's name
/// @return exit code, see --help
int runVerify(const std::vector<std::string>& words);

}  // namespace corrsel
