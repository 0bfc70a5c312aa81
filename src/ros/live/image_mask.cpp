#include "ros/live/image_mask.h"

#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <vector>

#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "features/parts/image_bytes.h"

namespace corrsel {

cv::Mat toMask(const sensor_msgs::ImageConstPtr& message, const core::MaskOptions& options) {
  const cv::Mat image = fromMsgInAllBits(message)->image;
  if (image.channels() == 1) return core::toMask(image, options);
  if (!options.classes.empty()) {
    throw std::invalid_argument("mask with encoding '" + message->encoding +
                                "'; a label image has one channel: mono8, mono16, 8UC1 or 16UC1");
  }
  cv::Mat first;
  cv::extractChannel(image, first, 0);
  return core::toMask(first, options);
}

cv::Mat readMaskFile(const std::string& path) {
  const std::string text = core::readTextFile(path);
  if (text.empty()) {
    throw std::runtime_error("'" + path + "' cannot be read or is empty; give the path of an image file");
  }
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  cv::Mat image;
  if (!core::isCutOff(bytes)) {
    constexpr int kGreyAsStored = cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH | cv::IMREAD_IGNORE_ORIENTATION;
    image = cv::imdecode(bytes, kGreyAsStored);
  }
  if (image.empty()) throw std::runtime_error("'" + path + "': " + core::undecodableCause(bytes));
  try {
    return core::toMask(image);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("'" + path + "': " + error.what());
  }
}

const cv::Mat& ImageMask::of(const sensor_msgs::ImageConstPtr& latched, const cv::Size& image) {
  if (latched == latched_ && image == size_) return mask_;
  cv::Mat mask;
  if (!fixed_.empty()) mask = core::fittedMask(fixed_, image);
  if (latched) {
    const cv::Mat newest = core::fittedMask(toMask(latched), image);
    mask = mask.empty() ? newest : newest & mask;
  }
  mask_ = mask;
  latched_ = latched;
  size_ = image;
  return mask_;
}

}  // namespace corrsel
