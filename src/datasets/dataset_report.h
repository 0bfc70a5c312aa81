#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"

namespace corrsel::core {

/// What a dataset's folder holds, what it lacks, and which files are broken.
struct DatasetReport {
  std::string dataset;
  std::size_t sequences = 0;
  std::size_t pairs = 0;              ///< pairs that should exist, broken ones included
  std::vector<std::string> missing;   ///< sequences of the published dataset that the folder lacks
  std::vector<std::string> ignored;   ///< folders that have no file of the layout
  std::vector<std::string> problems;  ///< one sentence for each broken pair: pair, file, fault and remedy

  /// A text to print; every line ends with a line break.
  std::string text() const;
};

/// How thoroughly describe() looks at a dataset.
enum class CheckDepth {
  kFiles,   ///< DatasetReader::check(): images need only exist
  kPixels,  ///< DatasetReader::read(): images are decoded, too
};

/// Checks the files of every pair. A broken pair is listed and does not end the check. Missing sequences are
/// known for vgg, symbench and adelaidermf.
DatasetReport describe(const DatasetReader& reader, CheckDepth depth);

}  // namespace corrsel::core
