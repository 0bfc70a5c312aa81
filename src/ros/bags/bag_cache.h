#pragma once

#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "ros/bags/dataset_bag_writer.h"

namespace corrsel {

/// $XDG_CACHE_HOME/corrsel, or ~/.cache/corrsel.
std::string cacheFolder();

/// A bag that was made from a dataset and is kept, so that the next run does not have to make it again.
struct CachedBag {
  std::string path;
  std::vector<UnreadablePair> problems;
  std::vector<std::string> remarks;  ///< on the images, see writeDatasetBag(); also of a bag that is reused
  bool reused = false;
};

/// Whether cachedDatasetBag() would reuse a bag.
bool hasCachedBag(const std::string& folder, const std::string& dataset, const core::DatasetReader& reader,
                  int seed);

/// Returns the bag of a dataset from `folder` and makes it if it is missing. The name contains a fingerprint
/// of the dataset's files (path, size, time of change) and of the seed; bags of the same dataset with another
/// fingerprint are removed when they have not been used for two days. Several processes may do this at the
/// same time, also on several machines that share the folder. A bag that lacks pairs is made anew each time,
/// so that its problems are reported each time. Throws core::DatasetError if the bag cannot be written.
CachedBag cachedDatasetBag(const std::string& folder, const std::string& dataset,
                           const core::DatasetReader& reader, int seed,
                           const BagProgress& progress = nullptr);

}  // namespace corrsel
