#pragma once

#include <string>

namespace corrsel {

/// Topics of a dataset bag.
namespace bag_topics {
inline constexpr char kLeft[] = "/left/image";                         ///< sensor_msgs/Image
inline constexpr char kRight[] = "/right/image";                       ///< sensor_msgs/Image
inline constexpr char kLeftCompressed[] = "/left/image/compressed";    ///< sensor_msgs/CompressedImage
inline constexpr char kRightCompressed[] = "/right/image/compressed";  ///< sensor_msgs/CompressedImage
inline constexpr char kGroundTruth[] = "/ground_truth";                ///< corrsel/GroundTruth
inline constexpr char kCorrespondences[] = "/correspondences";  ///< corrsel/Correspondences, given matches
}  // namespace bag_topics

/// Begins a frame id that names an image file instead of a camera, e.g. "image:db/1.jpg". Pairs with the same
/// name share this image.
inline constexpr char kImageFrame[] = "image:";

/// The name in such a frame id; empty for that of a camera.
inline std::string imageName(const std::string& frame_id) {
  const std::size_t length = std::string(kImageFrame).size();
  return frame_id.compare(0, length, kImageFrame) == 0 ? frame_id.substr(length) : "";
}

/// Topics of a bag and how its messages become pairs. The defaults are those of a dataset bag. A topic may be
/// given with or without the leading slash, a topic of images with or without "/compressed".
struct BagTopics {
  std::string left, right;             ///< images; empty = those of a dataset bag
  std::string left_info, right_info;   ///< sensor_msgs/CameraInfo; empty = camera_info beside the images
  std::string ground_truth;            ///< corrsel/GroundTruth; empty = /ground_truth
  std::string correspondences;         ///< corrsel/Correspondences, instead of images; empty = found by type
  std::string images = "auto";         ///< raw, rectified, auto: rectified if the topic's name has image_rect
  double max_stamp_difference = 0.01;  ///< between left and right image (and truth) of a pair, s, in [0, 10]

  static constexpr double kMaxStampDifference = 10.0;  ///< s

  /// Throws std::invalid_argument that names the option, its value and the accepted values.
  void check() const;

  /// Whether a topic of images, of calibrations or of the ground truth is named.
  bool nameImages() const { return !left.empty() || !right.empty(); }
  bool nameAnythingButMatches() const {
    return nameImages() || !left_info.empty() || !right_info.empty() || !ground_truth.empty();
  }
};

}  // namespace corrsel
