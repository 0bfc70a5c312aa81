#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// What a dataset's folder holds, what it lacks and what is wrong with which file.
struct DatasetReport {
  std::string dataset;
  std::size_t sequences = 0;
  std::size_t pairs = 0;              ///< that should be there, broken ones included
  std::vector<std::string> missing;   ///< sequences of the published dataset that the folder lacks
  std::vector<std::string> ignored;   ///< folders that hold none of the files that the layout asks for
  std::vector<std::string> problems;  ///< one sentence for each broken pair: pair, file, fault and remedy

  /// Lines for people, each ended by a line break.
  std::string text() const;
};

/// Tries every pair's files with DatasetReader::check(): a broken one becomes a problem and ends nothing.
/// What is missing is known of vgg, symbench and adelaidermf.
DatasetReport describe(const DatasetReader& reader);

}  // namespace corrsel::core
