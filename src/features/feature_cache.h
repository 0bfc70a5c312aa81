#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <utility>

#include "corrsel/features/extractor.h"

namespace corrsel::core {

/// Remembers the features of images that come again, such as a sequence's first image. Images are told apart
/// by their pixels, compared bit by bit, so that nothing can be mistaken; features that come from the cache
/// equal those of a new extraction and carry the seconds that theirs took. Nothing is kept on disk. Safe to
/// use from several threads.
class FeatureCache {
 public:
  /// @param max_bytes  of pixels and features together; the image used longest ago goes first, and one that
  /// is larger alone is not kept. 0 = nothing is kept.
  explicit FeatureCache(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// The features of both images: those that are not remembered are extracted, side by side where threads > 1
  /// and both are new. Throws what extract() throws.
  /// @param extractor  told apart by its address: must outlive the cache
  std::pair<std::shared_ptr<const Features>, std::shared_ptr<const Features>> extractPair(
      const FeatureExtractor& extractor, const cv::Mat& left, const cv::Mat& right, int threads);

  std::size_t bytes() const;
  /// How many images were found, and how many had to be extracted.
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
  mutable std::mutex mutex_;  ///< guards all below
  std::list<Entry> entries_;  ///< last used first
  std::size_t bytes_ = 0, hits_ = 0, misses_ = 0;
};

}  // namespace corrsel::core
