#pragma once

#include <cstddef>
#include <string>

namespace corrsel::core {

/// A part of a run that is divided among several machines: the pairs whose number in the undivided run leaves
/// the remainder `index` on division by `count`. Neighbouring pairs go to different parts, so that all parts
/// take about equally long.
struct Shard {
  std::size_t index = 0, count = 1;

  bool holds(std::size_t number) const { return number % count == index; }

  /// "1/3" for index 0 of 3; empty where the run is not divided.
  std::string text() const;

  /// Reads "i/n" with 1 <= i <= n <= 100000; an empty text means an undivided run. Throws
  /// std::invalid_argument.
  static Shard fromText(const std::string& text);
};

}  // namespace corrsel::core
