#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <utility>

#include "base/checksum.h"
#include "corrsel/features/extractor.h"

namespace corrsel::core {

/// Distinguishes most images quickly, by their sizes and pixels. The bytes of a row that do not fill a word
/// are left out.
Checksum checksumOf(const cv::Mat& image);

/// Keeps the features of images that occur in several pairs, such as a sequence's first image. Images are
/// compared pixel by pixel, so features are never taken for those of another image. Cached features equal
/// those of a new extraction, and their times are those of the extraction that made them. Nothing is kept on
/// disk. All members may be called from several threads.
class FeatureCache {
 public:
  /// @param max_bytes  bound on pixels and features together. When it is exceeded, the least recently used
  /// image is dropped first. An image that exceeds it alone is not kept. 0 = nothing is kept.
  explicit FeatureCache(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Returns the features of both images and extracts those that are not cached; both are extracted at the
  /// same time where threads > 1. Throws what extract() throws.
  /// @param extractor  identified by its address, so it must outlive the cache
  std::pair<std::shared_ptr<const Features>, std::shared_ptr<const Features>> extractPair(
      const FeatureExtractor& extractor, const cv::Mat& left, const cv::Mat& right, int threads);

  std::size_t bytes() const;
  /// How many images were found in the cache, and how many had to be extracted.
  std::size_t hits() const;
  std::size_t misses() const;

 private:
  struct Entry {
    const FeatureExtractor* extractor;
    std::uint64_t hash;
    cv::Mat image;
    std::shared_ptr<const Features> features;
    std::size_t bytes;
  };

  std::shared_ptr<const Features> find(const FeatureExtractor& extractor, const cv::Mat& image,
                                       std::uint64_t hash);
  void add(const FeatureExtractor& extractor, const cv::Mat& image, std::uint64_t hash,
           const std::shared_ptr<const Features>& features);

  const std::size_t max_bytes_;
  mutable std::mutex mutex_;  ///< guards the members below
  std::list<Entry> entries_;  ///< most recently used first
  std::size_t bytes_ = 0, hits_ = 0, misses_ = 0;
};

}  // namespace corrsel::core
