#pragma once

#include <atomic>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/database/colmap_store.h"
#include "corrsel/options.h"

namespace corrsel::core {

struct PairMatchingOptions : OptionSet {
  /// A match is dropped where its distance is not below this part of the distance of the second nearest
  /// descriptor, in either image; 1 = no such test.
  double ratio = 0.8;
  double memory_gib = 1;  ///< for descriptors that are kept for further pairs, GiB; 0 to 1e6
  bool again = false;     ///< match pairs that have matches already

  void visit(OptionVisitor& visitor) const override;
};

struct PairMatchingSummary {
  std::size_t pairs = 0;    ///< that were asked for
  std::size_t skipped = 0;  ///< of these, with matches already
  std::size_t matched = 0;  ///< of these, by this call
  std::size_t matches = 0;  ///< of the pairs that this call matched
  std::vector<std::string>
      faulty;  ///< images whose descriptors cannot be used, and why; their pairs are left
  bool interrupted = false;
};

/// Matches two images: features that are nearest to each other and pass the test of ratios from both sides.
/// Distances are Euclidean; of equally near descriptors the one in the lowest row counts.
/// @param first, second  descriptors of bytes, one row a keypoint, with the same number of columns
/// @return numbers of rows, ascending in the first one
/// Cost: O(first.rows * second.rows * columns); 9600 by 9600 of 128 bytes take 40 to 50 ms on one core with
/// AVX-512 VNNI, and 65 ms without the test of ratios. Exact: every descriptor is compared with every other
/// one, or excluded by a bound.
std::vector<KeypointPair> matchDescriptors(const cv::Mat& first, const cv::Mat& second, double ratio = 0.8);

/// All pairs of the images, ascending.
std::vector<ImagePairKey> exhaustivePairs(const std::vector<StoredImage>& images);

/// Every image and the `overlap` next ones in byte order of their names, ascending.
std::vector<ImagePairKey> sequentialPairs(const std::vector<StoredImage>& images, std::size_t overlap);

/// The pairs of a text file: two names of images a line, separated by white space; lines that are empty or
/// begin with # are skipped. @return ascending, every pair once
/// Throws StoreError naming file and line where a name is none of the images', or a line has another form.
std::vector<ImagePairKey> listedPairs(const std::filesystem::path& file,
                                      const std::vector<StoredImage>& images);

/// Matches the descriptors of pairs and stores the matches, a transaction every 500 pairs or 2 s. Pairs that
/// have rows in `matches` are skipped unless `again` is set, so that a call that was killed can be repeated.
///
/// The pairs are matched in blocks of images whose descriptors fit into the memory together, so that an image
/// is read rarely; what is stored depends neither on this order nor on the number of threads.
/// @param pairs     ascending
/// @param progress  called with the number of pairs done and the number of pairs to do; may be empty
/// @param interrupt where it becomes true, the pairs that are complete are stored
/// Throws StoreError, and std::invalid_argument for options out of range.
PairMatchingSummary matchPairs(ColmapStore& store, const std::vector<ImagePairKey>& pairs,
                               const PairMatchingOptions& options, int threads,
                               const std::function<void(std::size_t, std::size_t)>& progress = {},
                               const std::atomic<bool>* interrupt = nullptr);

}  // namespace corrsel::core
