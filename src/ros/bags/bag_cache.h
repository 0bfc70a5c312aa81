#pragma once

#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "ros/bags/dataset_bag.h"

namespace corrsel {

/// $XDG_CACHE_HOME/corrsel, or ~/.cache/corrsel.
std::string cacheFolder();

/// A bag made from a dataset, kept so that the next run does not have to make it again.
struct CachedBag {
  std::string path;
  std::vector<std::string> problems;  ///< pairs that could not be read, one sentence each
  bool reused = false;
};

/// Returns the bag of a dataset from `folder`, making it where it is missing. The name holds a fingerprint of
/// the dataset's files (path, size, time of change) and of the seed; bags of the same dataset with another
/// fingerprint are removed. Processes may do this side by side. A bag that lacks pairs is made anew each
/// time, so that its problems are reported each time. Throws core::DatasetError where it cannot be written.
CachedBag cachedDatasetBag(const std::string& folder, const std::string& dataset,
                           const core::DatasetReader& reader, int seed,
                           const BagProgress& progress = nullptr);

}  // namespace corrsel
