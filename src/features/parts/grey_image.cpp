#include "features/parts/grey_image.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

namespace corrsel::core {
namespace {

/// What turns values of this many bits into values of 8 bits.
double scaleOf(int bits) { return 255.0 / ((1 << bits) - 1); }

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

int largestValue(const cv::Mat& image) {
  double largest = 0;
  cv::Mat channel = image;
  for (int k = 0; k < std::min(image.channels(), 3); ++k) {
    if (image.channels() > 1) cv::extractChannel(image, channel, k);
    double value = 0;
    cv::minMaxLoc(channel, nullptr, &value);
    largest = std::max(largest, value);
  }
  return static_cast<int>(largest);
}

int significantBits(int largest_value) {
  int bits = 8;
  while (bits < kMaxBits && largest_value >= (1 << bits)) bits += 2;
  return bits;
}

cv::Mat toEightBits(const cv::Mat& image, int bits) {
  if (image.depth() != CV_16U) return image;
  cv::Mat result;
  image.convertTo(result, CV_8U, scaleOf(bits));
  return result;
}

cv::Size reducedSize(const cv::Size& size, double max_megapixels) {
  const double scale = std::sqrt(max_megapixels * 1e6 / (static_cast<double>(size.width) * size.height));
  if (scale >= 1) return size;
  const auto side = [scale](int length) { return std::max(1, static_cast<int>(length * scale)); };
  return {side(size.width), side(size.height)};
}

cv::Mat toGrey(const cv::Mat& image, double max_megapixels, GreyBuffer& buffer) {
  // OpenCV's functions write into an image that has the size and type of their result.
  cv::Mat grey = image;
  if (image.channels() > 1) {
    grey = inBuffer(image.size(), buffer.grey);
    cv::cvtColor(toEightBits(image), grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  } else if (image.depth() == CV_16U) {
    grey = inBuffer(image.size(), buffer.grey);
    image.convertTo(grey, CV_8U, scaleOf(kMaxBits));
  }
  const cv::Size size = reducedSize(grey.size(), max_megapixels);
  if (size == grey.size()) return grey;
  cv::Mat reduced = inBuffer(size, buffer.reduced);
  cv::resize(grey, reduced, reduced.size(), 0, 0, cv::INTER_AREA);
  return reduced;
}

cv::Mat equalized(const cv::Mat& grey, const ImageOptions& options, GreyBuffer& buffer) {
  if (options.equalize == ImageOptions::Equalize::kNone) return grey;
  cv::Mat result = inBuffer(grey.size(), buffer.equalized);
  // One for every call, since it keeps memory of its own and calls may be simultaneous.
  cv::createCLAHE(options.clahe_clip, {options.clahe_tiles, options.clahe_tiles})->apply(grey, result);
  return result;
}

cv::Mat detached(const cv::Mat& image) { return image.isSubmatrix() ? image.clone() : image; }

}  // namespace corrsel::core
