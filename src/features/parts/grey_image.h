#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace corrsel::core {

/// Memory for the grey image of one extraction, kept for the next one.
struct GreyBuffer {
  std::vector<std::uint8_t> grey, reduced;
};

/// Throws std::invalid_argument that names the type if an image is empty or if features cannot be extracted
/// from it. Possible are 8 and 16 bits with 1 (grey), 3 (BGR) or 4 (BGRA) channels.
void checkImage(const cv::Mat& image);

/// An image of 16 bits in 8 bits: a value v becomes v / 257, rounded, so that 65535 becomes 255. The full
/// range is mapped, as cv_bridge does for mono16; a camera that delivers fewer bits (10 to 14) must shift
/// them up, or its image is dark. An image of 8 bits is returned as it is.
cv::Mat toEightBits(const cv::Mat& image);

/// The image in grey, with one channel of 8 bits, reduced to at most `max_megapixels` (10^6 px). A grey image
/// of 8 bits that is small enough is returned as it is, without a copy, even if it is a part of another
/// image. Every other image of 8 bits is read once and converted into the buffer; values of 16 bits become 8
/// bits first. The result is valid until the buffer is used again.
/// @pre checkImage() accepts it
cv::Mat toGrey(const cv::Mat& image, double max_megapixels, GreyBuffer& buffer);

/// The image itself or, if it is a part of another one, a copy. Some algorithms of OpenCV read pixels beyond
/// the border of a part.
cv::Mat detached(const cv::Mat& image);

}  // namespace corrsel::core
