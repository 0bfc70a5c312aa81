#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <unordered_map>
#include <utility>

#include "corrsel/database/pair_store.h"

namespace corrsel::core {

/// The keypoints of the images that were used last, within a bound of memory. Not thread-safe.
class KeypointCache {
 public:
  /// @param bytes  bound of what is kept; the keypoints of the image that was asked for last are kept anyway
  KeypointCache(const PairStore& store, std::size_t bytes) : store_(store), bound_(bytes) {}

  /// The keypoints of an image, which stay valid as long as somebody holds them. Throws what
  /// PairStore::keypoints() throws. O(1) if they are kept.
  std::shared_ptr<const StoredKeypoints> get(std::uint32_t image) {
    const auto found = entries_.find(image);
    if (found != entries_.end()) {
      order_.splice(order_.begin(), order_, found->second);
      return order_.front().second;
    }
    auto keypoints = std::make_shared<const StoredKeypoints>(store_.keypoints(image));
    bytes_ += bytesOf(*keypoints);
    order_.emplace_front(image, std::move(keypoints));
    entries_[image] = order_.begin();
    while (bytes_ > bound_ && order_.size() > 1) dropOldest();
    return order_.front().second;
  }

  /// Memory of what is kept.
  std::size_t bytes() const { return bytes_; }

 private:
  using Entry = std::pair<std::uint32_t, std::shared_ptr<const StoredKeypoints>>;

  static std::size_t bytesOf(const StoredKeypoints& keypoints) {
    constexpr std::size_t kOfEntry = 192;  // list, map and control block
    return keypoints.positions.capacity() * sizeof(cv::Point2f) +
           keypoints.frames.capacity() * sizeof(AffineFrame) + kOfEntry;
  }

  void dropOldest() {
    bytes_ -= bytesOf(*order_.back().second);
    entries_.erase(order_.back().first);
    order_.pop_back();
  }

  const PairStore& store_;
  std::size_t bound_, bytes_ = 0;
  std::list<Entry> order_;  ///< the image that was used last comes first
  std::unordered_map<std::uint32_t, std::list<Entry>::iterator> entries_;
};

}  // namespace corrsel::core
