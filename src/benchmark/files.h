#pragma once

#include <string>

namespace corrsel::core {

/// Writes a file through a second one that takes its place, so that a reader never sees half of it. Throws
/// RunFolderError where that fails.
void writeFile(const std::string& path, const std::string& text);

/// Appends to a file of a run's folder; the text is on disk when the call returns. Throws RunFolderError
/// where that fails.
void appendToFile(const std::string& path, const std::string& text);

}  // namespace corrsel::core
