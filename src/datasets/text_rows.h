#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace corrsel::core {

/// A line of a text file that is a table, with its place for error texts.
struct TextRow {
  std::string path;
  std::size_t line = 0;  ///< from 1
  std::vector<std::string> words;

  /// "PATH: line N"
  std::string place() const { return path + ": line " + std::to_string(line); }

  /// Throws DatasetError: the place and the fault.
  [[noreturn]] void fail(const std::string& fault) const;

  /// Throws DatasetError unless the row has that many words. @param meaning  of the words, e.g. "x y z"
  void requireWords(std::size_t count, const std::string& meaning) const;

  /// Reads a word as a finite number. Throws DatasetError that names the place and the word.
  double number(std::size_t word) const;

  /// Reads words from `first` on as finite numbers.
  std::vector<double> numbers(std::size_t first, std::size_t count) const;

  /// Reads a word as a time. Throws DatasetError likewise.
  /// @param decimals  of the word's unit in nanoseconds: 9 for seconds, 0 for nanoseconds
  /// @return ns, exactly; digits beyond are dropped
  std::int64_t time(std::size_t word, int decimals) const;
};

/// The rows of a text file, split at white space and commas. Empty lines and those that begin with '#' are
/// left out. Throws DatasetError where the file is missing or cannot be opened.
/// @param remedy  for a missing file
std::vector<TextRow> readTextRows(const std::string& path, const std::string& remedy);

}  // namespace corrsel::core
