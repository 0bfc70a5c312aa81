#include "features/parts/visible_area.h"

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "base/size_text.h"

namespace corrsel::core {
namespace {

void checkMask(const cv::Mat& mask, const cv::Size& image) {
  if (mask.empty()) return;
  if (mask.type() != CV_8UC1) {
    throw std::invalid_argument("mask has type " + cv::typeToString(mask.type()) +
                                "; needed: 8 bits with 1 channel");
  }
  if (mask.size() != image) {
    throw std::invalid_argument("mask has " + sizeText(mask.size()) + " px; needed: " + sizeText(image) +
                                " px, the size of the image");
  }
}

}  // namespace

cv::Rect visibleArea(const FeatureRegion& region, const cv::Size& image) {
  checkMask(region.mask, image);
  const cv::Rect& area = region.area;
  if (area.empty()) return {{0, 0}, image};
  // In 64 bits, because the sum of two arbitrary ints must fit.
  const auto end = [](int begin, int length, int limit) {
    return static_cast<int>(std::min<std::int64_t>(std::int64_t{begin} + length, limit));
  };
  const cv::Point first(std::max(area.x, 0), std::max(area.y, 0));
  const cv::Point last(end(area.x, area.width, image.width), end(area.y, area.height, image.height));
  if (last.x <= first.x || last.y <= first.y) {
    throw std::invalid_argument("the area of " + sizeText(area.size()) + " px at (" + std::to_string(area.x) +
                                ", " + std::to_string(area.y) + ") lies outside the image of " +
                                sizeText(image) + " px");
  }
  return {first, last};
}

}  // namespace corrsel::core
