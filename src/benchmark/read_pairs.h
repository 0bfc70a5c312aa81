#pragma once

#include <functional>
#include <string>

#include "corrsel/benchmark/results.h"

namespace corrsel::core {

/// Calls `use` with each row of a pairs.csv. A last line that was cut off is left out, and makes the result
/// false. Throws RunFolderError naming `file` and the line where the format or the header is another one, a
/// line is no row or a row appears twice. O(rows log rows); of each row, 16 bytes stay in memory.
bool forEachPairRow(const std::string& file, const std::function<void(const ResultRow&)>& use);
bool forEachPoseRow(const std::string& file,
                    const std::function<void(const PoseRow&)>& use);  ///< of a poses.csv

}  // namespace corrsel::core
