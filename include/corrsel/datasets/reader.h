#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/image_pair.h"

namespace corrsel::core {

/// A dataset folder or one of its files is missing or broken.
class DatasetError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Reads a dataset folder pair by pair: one pair in memory at a time.
class DatasetReader {
 public:
  virtual ~DatasetReader() = default;

  /// Number of pairs the dataset should have, in a fixed order, broken ones included.
  virtual std::size_t size() const = 0;

  virtual PairId id(std::size_t index) const = 0;

  /// Reads one pair. Throws DatasetError naming the file, what is wrong with it and the remedy.
  virtual ImagePair read(std::size_t index) const = 0;

  /// Files that the pairs are read from or made of; their sizes and times identify the dataset's state.
  virtual std::vector<std::string> files() const = 0;
};

/// Opens dataset `name` from folder `path`. Throws std::invalid_argument for an unknown name (listing the
/// valid ones) and DatasetError where the folder is missing or holds nothing of the dataset.
/// @param seed  used by datasets that generate pairs (sample)
std::unique_ptr<DatasetReader> openDataset(const std::string& name, const std::string& path, int seed = 0);

/// Names accepted by openDataset().
std::vector<std::string> datasetNames();

}  // namespace corrsel::core
