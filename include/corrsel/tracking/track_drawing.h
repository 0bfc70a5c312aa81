#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <unordered_map>
#include <vector>

namespace corrsel::core {

/// Draws the tracks of a sequence on its newest image: a disc at each feature and a tail through its places
/// in the frames before. Tracks that were seen in all frames of the tail are bluish green, and those that
/// have just begun are yellow.
class TrackDrawing {
 public:
  /// @param tail  number of frames that a tail goes back; at least 1
  /// Throws std::invalid_argument for 0.
  explicit TrackDrawing(std::size_t tail);

  /// Adds a frame. O(tracks).
  /// @param ids     identities of the tracks. @param points  as many, px; those that are not finite are left
  /// out Throws std::invalid_argument where their numbers differ.
  void add(const std::vector<std::uint64_t>& ids, const std::vector<cv::Point2f>& points);

  /// Draws the newest frame. O(pixels + tracks * tail).
  /// @param image  8-bit grey or BGR
  /// @return 8-bit BGR, a copy
  cv::Mat draw(const cv::Mat& image) const;

  /// Forgets all frames.
  void reset() { frames_.clear(); }

 private:
  using Frame = std::unordered_map<std::uint64_t, cv::Point2f>;

  std::size_t tail_;
  std::deque<Frame> frames_;  ///< newest last
};

}  // namespace corrsel::core
