#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace corrsel::core {

/// How much of something a number of pairs took.
struct Measured {
  std::size_t count = 0;  ///< of pairs or pictures
  double seconds = 0, bytes = 0;

  /// The same for another count, in proportion; zero where nothing was measured.
  Measured scaledTo(std::size_t other) const;
};

/// What a trial with some pairs of a dataset or bag showed.
struct Trial {
  std::string name;            ///< of the dataset or bag
  std::size_t pairs = 0;       ///< that the run takes from it
  std::size_t selections = 0;  ///< of the pairs that were tried, `run.count`
  Measured run, pictures;
};

/// What a run will take.
struct Estimate {
  std::size_t pairs = 0;
  double selections = 0;
  double seconds = 0, run_bytes = 0;

  Estimate& operator+=(const Estimate& other);
};

/// In proportion to what the trial took, without pictures.
Estimate estimateOf(const Trial& trial);

/// At most this many pictures are drawn, see BenchmarkRunner::drawExamples().
/// @param selectors  without keep_all
std::size_t maxPictures(const std::vector<Trial>& trials, std::size_t selectors);

/// A table with a line per trial, the pictures and the sum. A trial without any pair has "?" for what is
/// unknown.
/// @param pictures  number of pictures; 0: none are drawn
std::string estimateTable(const std::vector<Trial>& trials, std::size_t pictures);

/// The sum of all lines of the table.
Estimate sumOf(const std::vector<Trial>& trials, std::size_t pictures);

}  // namespace corrsel::core
