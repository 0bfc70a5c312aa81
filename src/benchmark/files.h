#pragma once

#include <functional>
#include <iosfwd>
#include <string>

namespace corrsel::core {

/// Calls `use` with each complete line of a file, without its line end; one line is in memory at a time.
/// Returns whether the last line was complete, too. A file that cannot be read has no lines.
bool forEachLine(const std::string& path, const std::function<void(const std::string&)>& use);

/// Writes a file through a second one that takes its place, so that a reader never sees half of it. Throws
/// RunFolderError where that fails.
void writeFile(const std::string& path, const std::string& text);

/// As above, where `write` writes the text in pieces.
void writeFile(const std::string& path, const std::function<void(std::ostream&)>& write);

/// Appends to a file of a run's folder; the text is on disk when the call returns. Throws RunFolderError
/// where that fails.
void appendToFile(const std::string& path, const std::string& text);

}  // namespace corrsel::core
