#include "corrsel/matching/match_mask.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>

#include "base/size_text.h"

namespace corrsel::core {
namespace {

/// Whether a point lies on a zero of the mask.
bool isMasked(const cv::Mat& mask, float x, float y) {
  if (mask.empty() || !std::isfinite(x) || !std::isfinite(y)) return false;
  // The conversion rounds down, as the number is not negative.
  const auto nearest = [](float at, int size) {
    return static_cast<int>(std::clamp(at + 0.5F, 0.0F, static_cast<float>(size - 1)));
  };
  return mask.at<std::uint8_t>(nearest(y, mask.rows), nearest(x, mask.cols)) == 0;
}

}  // namespace

cv::Mat toMask(const cv::Mat& image, const MaskOptions& options) {
  if (image.type() != CV_8UC1 && image.type() != CV_16UC1) {
    throw std::invalid_argument("mask has type " + cv::typeToString(image.type()) +
                                "; needed: 8 or 16 bits with 1 channel");
  }
  constexpr int kBand = 32;  // rows that stay in the cache from one class to the next
  const std::vector<int> labels = options.classes.empty() ? std::vector<int>{0} : options.classes;
  cv::Mat mask(image.size(), CV_8UC1, cv::Scalar(255)), other;
  for (int y = 0; y < image.rows; y += kBand) {
    const cv::Range rows(y, std::min(y + kBand, image.rows));
    cv::Mat band = mask.rowRange(rows);
    for (const int label : labels) {
      cv::compare(image.rowRange(rows), label, other, cv::CMP_NE);
      band &= other;
    }
  }
  if (options.dilation > 0) {
    // To dilate the zeros is to erode the rest. A square is what OpenCV takes apart into rows and columns.
    const int side = 2 * options.dilation + 1;
    cv::erode(mask, mask, cv::getStructuringElement(cv::MORPH_RECT, {side, side}));
  }
  return mask;
}

cv::Mat fittedMask(const cv::Mat& mask, const cv::Size& image) {
  if (image.empty() || mask.size() == image) return mask;
  const std::int64_t wanted = std::int64_t{mask.cols} * image.height;
  const std::int64_t present = std::int64_t{mask.rows} * image.width;
  // A network rounds one of the sides to whole pixels.
  if (std::abs(wanted - present) > std::max(image.width, image.height)) {
    throw std::invalid_argument("mask has " + sizeText(mask.size()) + " px; needed: " + sizeText(image) +
                                " px, the size of the image, or the same ratio of width and height");
  }
  cv::Mat scaled;
  cv::resize(mask, scaled, image, 0, 0, cv::INTER_NEAREST);
  return scaled;
}

std::vector<std::uint32_t> unmaskedRows(const Correspondences& matches, const cv::Mat& left_mask,
                                        const cv::Mat& right_mask) {
  std::vector<std::uint32_t> rows;
  rows.reserve(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (isMasked(left_mask, matches.left_x[i], matches.left_y[i])) continue;
    if (isMasked(right_mask, matches.right_x[i], matches.right_y[i])) continue;
    rows.push_back(static_cast<std::uint32_t>(i));
  }
  return rows;
}

}  // namespace corrsel::core
