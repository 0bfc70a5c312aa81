#pragma once

#include <sensor_msgs/Image.h>

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <utility>

#include "corrsel/matching/match_mask.h"

namespace corrsel {

/// core::toMask() of a message. Of an image of several channels without classes, the first one counts. Throws
/// std::exception that names the encoding of an image that is neither a mask nor a label image.
cv::Mat toMask(const sensor_msgs::ImageConstPtr& message, const core::MaskOptions& options = {});

/// Reads a mask from an image file of any format that OpenCV reads. Throws std::runtime_error that names the
/// file, the cause and the remedy.
cv::Mat readMaskFile(const std::string& path);

/// The mask of the images of a camera: a fixed one, which is that of the robot's own body, and the newest one
/// of a topic. It is made anew only when the message or the size of the images changes. Not thread-safe.
class ImageMask {
 public:
  /// @param fixed  8-bit, one channel; empty = none
  explicit ImageMask(cv::Mat fixed = {}) : fixed_(std::move(fixed)) {}

  /// Excludes what either mask excludes; empty where there is none. Throws what core::fittedMask() and
  /// toMask() throw.
  /// @param latched  null = none
  const cv::Mat& of(const sensor_msgs::ImageConstPtr& latched, const cv::Size& image);

 private:
  const cv::Mat fixed_;
  sensor_msgs::ImageConstPtr latched_;
  cv::Size size_;
  cv::Mat mask_;  ///< of latched_ and size_
};

}  // namespace corrsel
