#include "database/track_forest.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace corrsel::core {

void KeypointNumbers::finish() {
  size_ = 0;
  for (auto& [image, room] : rooms_) {
    room.first = static_cast<std::uint32_t>(size_);
    size_ += room.count;
    if (size_ >= TrackForest::kNone) {
      throw std::length_error("tracks: the images have " + std::to_string(size_) +
                              " keypoints or more; at most 4294967294 can be numbered, so divide the images");
    }
  }
}

KeypointNumbers::Room KeypointNumbers::room(std::uint32_t image) const {
  const auto found = rooms_.find(image);
  return found == rooms_.end() ? Room() : found->second;
}

TrackForest::TrackForest(const KeypointNumbers& numbers)
    : parent_(numbers.size()), next_(numbers.size(), kNone), image_(numbers.size()) {
  for (std::size_t i = 0; i < parent_.size(); ++i) parent_[i] = static_cast<std::uint32_t>(i);
  for (const auto& [image, room] : numbers.rooms())
    std::fill_n(image_.begin() + room.first, room.count, image);
}

std::uint32_t TrackForest::first(std::uint32_t keypoint) {
  while (parent_[keypoint] != keypoint) {
    parent_[keypoint] = parent_[parent_[keypoint]];
    keypoint = parent_[keypoint];
  }
  return keypoint;
}

/// Whether two sets, given by their first members, hold a keypoint of one image. Both lists are in the order
/// of the images, because the numbers are.
bool TrackForest::conflict(std::uint32_t a, std::uint32_t b) const {
  while (a != kNone && b != kNone) {
    if (image_[a] == image_[b]) return true;
    std::uint32_t& earlier = image_[a] < image_[b] ? a : b;
    earlier = next_[earlier];
  }
  return false;
}

/// Merges the lists of two sets, given by their first members, of which a is the smaller one.
void TrackForest::merge(std::uint32_t a, std::uint32_t b) {
  parent_[b] = a;
  std::uint32_t last = a;
  a = next_[a];
  while (b != kNone) {
    if (a == kNone || b < a) std::swap(a, b);
    next_[last] = a;
    last = a;
    a = next_[a];
  }
  next_[last] = a;
}

bool TrackForest::join(std::uint32_t a, std::uint32_t b) {
  a = first(a);
  b = first(b);
  if (a == b) return true;
  if (conflict(a, b)) return false;
  merge(std::min(a, b), std::max(a, b));
  return true;
}

}  // namespace corrsel::core
