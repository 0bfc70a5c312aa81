#pragma once

#include <ros/time.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "corrsel/image_pair.h"

namespace corrsel {

struct DatasetBagOptions {
  bool compressed = false;         ///< images as PNG instead of raw
  double period = 0.5;             ///< between the stamps of two pairs, s; at least 1e-3
  ros::Time start = ros::Time(1);  ///< stamp of the first pair; fixed, so that equal input gives equal files
};

/// Writes image pairs with their ground truth as a bag that both the benchmark and the nodelets can read. All
/// messages of a pair carry the same stamp, which is also their time in the bag. The file is written as
/// `path` + ".part" and gets its final name in close(). Without close() the unfinished file is removed.
class DatasetBagWriter {
 public:
  /// Throws std::invalid_argument for a period out of range, and core::DatasetError if the file cannot be
  /// created.
  explicit DatasetBagWriter(const std::string& path, const DatasetBagOptions& options = {});
  ~DatasetBagWriter();
  DatasetBagWriter(const DatasetBagWriter&) = delete;
  DatasetBagWriter& operator=(const DatasetBagWriter&) = delete;

  /// Appends one pair. One with given matches may have no images. Throws core::DatasetError for images that
  /// are not 8-bit grey or BGR (nothing of the pair is written then) and if writing fails.
  void write(const core::ImagePair& pair);

  /// Completes the file under its final name. An existing file of that name is replaced.
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Called after every pair, whether it was written or not.
using BagProgress = std::function<void(std::size_t done, std::size_t total, const core::PairId& pair)>;

/// A pair of a dataset that cannot be read.
struct UnreadablePair {
  core::PairId id;
  std::string error;  ///< one sentence: file, fault and remedy

  std::string text() const { return id.text() + ": " + error; }
};

/// Converts a dataset to a bag. Pairs that cannot be read are left out and appended to `problems` (may be
/// null). `remarks` (may be null) receives those of the reader and what was done to images of 16 bits, once
/// per number of bits. Throws core::DatasetError if writing fails.
/// @return number of pairs written; if it is 0, no file is created
std::size_t writeDatasetBag(const core::DatasetReader& reader, const std::string& path,
                            const DatasetBagOptions& options, const BagProgress& progress = nullptr,
                            std::vector<UnreadablePair>* problems = nullptr,
                            std::vector<std::string>* remarks = nullptr);

}  // namespace corrsel
