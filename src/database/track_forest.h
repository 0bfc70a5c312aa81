#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

namespace corrsel::core {

/// Numbers of the keypoints of all images, from 0 on, in the order of the images.
class KeypointNumbers {
 public:
  struct Room {
    std::uint32_t first = 0;
    std::uint64_t count = 0;
  };

  /// Makes room for a keypoint of an image and for those before it.
  void include(std::uint32_t image, std::uint32_t keypoint) {
    Room& room = rooms_[image];
    room.count = std::max(room.count, std::uint64_t{keypoint} + 1);
  }

  /// Gives the rooms their places, after the last include(). Throws std::length_error for more than 2^32 - 2
  /// keypoints.
  void finish();

  /// The number of the first keypoint of an image, and for how many there is room; none for an image that was
  /// not included.
  Room room(std::uint32_t image) const;

  /// All images with their rooms, in ascending order.
  const std::map<std::uint32_t, Room>& rooms() const { return rooms_; }

  /// Number of keypoints for which there is room.
  std::size_t size() const { return size_; }

 private:
  std::map<std::uint32_t, Room> rooms_;
  std::size_t size_ = 0;
};

/// Disjoint sets of keypoints, of which no set holds two of one image.
///
/// Each set is a list in the order of the numbers, whose first member represents it.
class TrackForest {
 public:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;

  explicit TrackForest(const KeypointNumbers& numbers);

  /// The first member of the set of a keypoint. O(log N), amortised.
  std::uint32_t first(std::uint32_t keypoint);

  /// The next member of its set, or kNone.
  std::uint32_t next(std::uint32_t keypoint) const { return next_[keypoint]; }

  std::uint32_t image(std::uint32_t keypoint) const { return image_[keypoint]; }

  /// Joins the sets of two keypoints, unless both hold a keypoint of one image. O(members).
  /// @return whether both are in one set now
  bool join(std::uint32_t a, std::uint32_t b);

 private:
  bool conflict(std::uint32_t a, std::uint32_t b) const;
  void merge(std::uint32_t a, std::uint32_t b);

  std::vector<std::uint32_t> parent_, next_, image_;  // by number
};

}  // namespace corrsel::core
