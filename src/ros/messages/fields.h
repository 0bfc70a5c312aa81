#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <optional>
#include <stdexcept>
#include <string>

#include "corrsel/Camera.h"
#include "corrsel/ros/cameras.h"
#include "ros/messages/image_side.h"

// Checks of fields that several messages have. They throw std::invalid_argument that names message and field.
namespace corrsel {

[[noreturn]] inline void refuse(const std::string& message, const std::string& field,
                                const std::string& what) {
  throw std::invalid_argument(message + " message: " + field + " " + what);
}

inline void requireLength(const std::string& message, const std::string& field, std::size_t length,
                          std::size_t expected, bool optional) {
  if (length == expected || (optional && length == 0)) return;
  refuse(message, field,
         "has " + std::to_string(length) + " elements, expected " + (optional ? "0 or " : "") +
             std::to_string(expected));
}

/// @param prefix  of the fields, e.g. "left_"
inline cv::Size imageSize(const std::string& message, const std::string& prefix, std::uint32_t width,
                          std::uint32_t height) {
  if (width > kMaxImageSide) refuse(message, prefix + "width", "is " + std::to_string(width) + " px");
  if (height > kMaxImageSide) refuse(message, prefix + "height", "is " + std::to_string(height) + " px");
  return {static_cast<int>(width), static_cast<int>(height)};
}

inline std::optional<core::Camera> readCamera(const std::string& message, const std::string& field,
                                              const Camera& msg) {
  try {
    return fromMsg(msg);
  } catch (const std::invalid_argument& error) {
    refuse(message, field + ":", error.what());
  }
}

}  // namespace corrsel
