#include "features/parts/grey_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace corrsel::core {
namespace {

constexpr double kSixteenToEightBits = 255.0 / 65535.0;

/// An image of the given size, 8 bits, one channel, in the memory of the buffer.
cv::Mat inBuffer(const cv::Size& size, std::vector<std::uint8_t>& buffer) {
  const std::size_t pixels = static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height);
  if (buffer.size() < pixels) buffer.resize(pixels);
  return cv::Mat(size, CV_8U, buffer.data());
}

}  // namespace

void checkImage(const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("image is empty");
  if ((image.depth() != CV_8U && image.depth() != CV_16U) || image.channels() == 2 || image.channels() > 4) {
    throw std::invalid_argument("image has type " + cv::typeToString(image.type()) +
                                "; needed: 8 or 16 bits with 1, 3 (BGR) or 4 (BGRA) channels");
  }
}

cv::Mat toEightBits(const cv::Mat& image) {
  if (image.depth() != CV_16U) return image;
  cv::Mat result;
  image.convertTo(result, CV_8U, kSixteenToEightBits);
  return result;
}

cv::Mat toGrey(const cv::Mat& image, double max_megapixels, GreyBuffer& buffer) {
  // OpenCV's functions write into an image that has the size and type of their result.
  cv::Mat grey = image;
  if (image.channels() > 1) {
    grey = inBuffer(image.size(), buffer.grey);
    cv::cvtColor(toEightBits(image), grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  } else if (image.depth() == CV_16U) {
    grey = inBuffer(image.size(), buffer.grey);
    image.convertTo(grey, CV_8U, kSixteenToEightBits);
  }
  const double scale = std::sqrt(max_megapixels * 1e6 / (static_cast<double>(grey.cols) * grey.rows));
  if (scale >= 1) return grey;
  const auto side = [scale](int length) { return std::max(1, static_cast<int>(length * scale)); };
  cv::Mat reduced = inBuffer({side(grey.cols), side(grey.rows)}, buffer.reduced);
  cv::resize(grey, reduced, reduced.size(), 0, 0, cv::INTER_AREA);
  return reduced;
}

cv::Mat detached(const cv::Mat& image) { return image.isSubmatrix() ? image.clone() : image; }

}  // namespace corrsel::core
