#pragma once

#include <opencv2/core/types.hpp>
#include <string>

namespace corrsel::core {

/// "640x480"
inline std::string sizeText(const cv::Size& size) {
  return std::to_string(size.width) + "x" + std::to_string(size.height);
}

}  // namespace corrsel::core
