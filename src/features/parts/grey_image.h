#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "features/parts/image_options.h"

namespace corrsel::core {

/// Memory for the grey image of one extraction, kept for the next one.
struct GreyBuffer {
  std::vector<std::uint8_t> grey, reduced, equalized;
};

/// Throws std::invalid_argument that names the type if an image is empty or if features cannot be extracted
/// from it. Possible are 8 and 16 bits with 1 (grey), 3 (BGR) or 4 (BGRA) channels.
void checkImage(const cv::Mat& image);

constexpr int kMaxBits = 16;

/// The largest value of grey or colour; alpha does not count. O(pixels).
/// @pre checkImage() accepts the image
int largestValue(const cv::Mat& image);

/// The number of bits of images whose largest value this is: 8, 10, 12, 14 or 16. Cameras deliver these
/// numbers of bits, and the brightness of the scene hardly changes which one it is.
int significantBits(int largest_value);

/// An image of 16 bits in 8 bits: a value v becomes 255 v / (2^bits - 1), rounded, and at most 255. With 16
/// bits this is v / 257, as cv_bridge maps mono16. An image of 8 bits is returned as it is.
/// @param bits  8 to 16, the same for images that are compared with each other
cv::Mat toEightBits(const cv::Mat& image, int bits = kMaxBits);

/// The size to which toGrey() reduces an image of this size: its own, or a smaller one.
/// @param max_megapixels  10^6 px
cv::Size reducedSize(const cv::Size& size, double max_megapixels);

/// The image in grey, with one channel of 8 bits, reduced to at most `max_megapixels` (10^6 px). A grey image
/// of 8 bits that is small enough is returned as it is, without a copy, even if it is a part of another
/// image. Every other image of 8 bits is read once and converted into the buffer; values of 16 bits become 8
/// bits first. The result is valid until the buffer is used again.
/// @pre checkImage() accepts it
cv::Mat toGrey(const cv::Mat& image, double max_megapixels, GreyBuffer& buffer);

/// The image with its contrast raised as the options ask, in the memory of the buffer; the image itself,
/// without a copy, where they ask for nothing. The result is valid until the buffer is used again. The cost
/// of CLAHE is that of OpenCV's, some 1.5 ms for 640 x 480 px on one thread.
/// @param grey  8 bits, one channel
cv::Mat equalized(const cv::Mat& grey, const ImageOptions& options, GreyBuffer& buffer);

/// The image itself or, if it is a part of another one, a copy. Some algorithms of OpenCV read pixels beyond
/// the border of a part.
cv::Mat detached(const cv::Mat& image);

}  // namespace corrsel::core
