#pragma once

#include <cstddef>
#include <functional>
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
  std::vector<std::size_t> broken;    ///< indices of these pairs

  /// A text to print; every line ends with a line break.
  std::string text() const;
};

/// Indices of at most `limit` of `count` things, evenly spaced and in ascending order; all where there are no
/// more.
std::vector<std::size_t> evenlySpaced(std::size_t count, std::size_t limit);

/// What describe() tells while it works. Both functions may be empty.
struct DescribeCalls {
  std::function<void(const ImagePair&)> decoded;                       ///< with each pair that was decoded
  std::function<void(std::size_t done, const PairId&)> progress = {};  ///< after each pair, broken or not
};

/// Checks the files of every pair (DatasetReader::check()), and decodes the images of some of them. A broken
/// pair is listed and does not end the check. Missing sequences are known for vgg, symbench and adelaidermf.
/// @param decoded  indices of the pairs whose images are decoded, too (DatasetReader::read()), in ascending
/// order
DatasetReport describe(const DatasetReader& reader, const std::vector<std::size_t>& decoded,
                       const DescribeCalls& calls = {});

}  // namespace corrsel::core
