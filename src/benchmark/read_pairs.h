#pragma once

#include <string>
#include <vector>

#include "corrsel/benchmark/results.h"

namespace corrsel::core {

/// The rows of a pairs.csv; row i is line i + 2. A last line that was cut off is left out. Throws
/// RunFolderError naming `file` and the line where the header is another one, a line is no row or a row
/// appears twice. O(rows log rows).
std::vector<ResultRow> parsePairs(const std::string& file, const std::string& text);

}  // namespace corrsel::core
