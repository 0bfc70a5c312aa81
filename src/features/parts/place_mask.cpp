#include "features/parts/place_mask.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "features/parts/feature_list.h"

namespace corrsel::core {
namespace {

// As many pixels as a 64-bit word has bytes.
constexpr int kTile = 8;

/// The integral image of the tiles in which some pixel is not zero; the tiles at the right and at the bottom
/// may be smaller.
cv::Mat integralOfTiles(const cv::Mat& mask) {
  const int rows = (mask.rows + kTile - 1) / kTile, columns = (mask.cols + kTile - 1) / kTile;
  cv::Mat integral(rows + 1, columns + 1, CV_32S, cv::Scalar(0));
  std::vector<std::uint64_t> united(static_cast<std::size_t>(columns));  // the rows of a row of tiles
  const auto whole = static_cast<std::size_t>(mask.cols / kTile);
  for (int row = 0; row < rows; ++row) {
    std::fill(united.begin(), united.end(), std::uint64_t{0});
    for (int y = row * kTile; y < std::min((row + 1) * kTile, mask.rows); ++y) {
      const std::uint8_t* const line = mask.ptr<std::uint8_t>(y);
      for (std::size_t column = 0; column < whole; ++column) {
        std::uint64_t pixels = 0;
        std::memcpy(&pixels, line + column * kTile, kTile);
        united[column] |= pixels;
      }
      for (int x = static_cast<int>(whole) * kTile; x < mask.cols; ++x) united.back() |= line[x];
    }
    const int* const above = integral.ptr<int>(row);
    int* const here = integral.ptr<int>(row + 1);
    for (int column = 0, sum = 0; column < columns; ++column) {
      sum += united[static_cast<std::size_t>(column)] != 0;
      here[column + 1] = above[column + 1] + sum;
    }
  }
  return integral;
}

/// The pixel in [0, size) that is nearest to a coordinate.
int nearestPixel(float at, int size) {
  // The conversion rounds down, as the number is not negative.
  return static_cast<int>(std::clamp(at + 0.5F, 0.0F, static_cast<float>(size - 1)));
}

}  // namespace

AreaTransform::AreaTransform(const cv::Size& seen, const cv::Rect& area)
    : reduced_(seen != area.size()),
      left_(static_cast<float>(area.x)),
      top_(static_cast<float>(area.y)),
      x_scale_(static_cast<float>(area.width) / static_cast<float>(seen.width)),
      y_scale_(static_cast<float>(area.height) / static_cast<float>(seen.height)) {}

void AreaTransform::apply(Features& features) const {
  const float scale = std::sqrt(x_scale_ * y_scale_);
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    cv::KeyPoint& keypoint = features.keypoints[i];
    AffineFrame& frame = features.frames[i];
    if (reduced_) {
      keypoint.size *= scale;
      for (const std::size_t k : {0, 1, 3, 4}) frame[k] *= scale;
    }
    keypoint.pt = (*this)(keypoint.pt);
    frame[2] = keypoint.pt.x;
    frame[5] = keypoint.pt.y;
  }
}

PlaceMask::PlaceMask(const cv::Mat& mask, const AreaTransform& to_mask)
    : mask_(mask), allowed_tiles_(integralOfTiles(mask)), to_mask_(to_mask) {}

bool PlaceMask::allows(const cv::Point2f& place) const {
  if (everywhere()) return true;
  const cv::Point2f at = to_mask_(place);
  return mask_.at<std::uint8_t>(nearestPixel(at.y, mask_.rows), nearestPixel(at.x, mask_.cols)) != 0;
}

bool PlaceMask::allowsAny(const cv::Rect& pixels) const {
  if (pixels.empty()) return false;
  if (everywhere()) return true;
  // Rounding is monotone, so no place of the rectangle is mapped beyond its corners.
  const cv::Point2f corner(static_cast<float>(pixels.x) - 0.5F, static_cast<float>(pixels.y) - 0.5F);
  const cv::Point2f first = to_mask_(corner);
  const cv::Point2f last =
      to_mask_({corner.x + static_cast<float>(pixels.width), corner.y + static_cast<float>(pixels.height)});
  const int left = nearestPixel(first.x, mask_.cols) / kTile;
  const int right = nearestPixel(last.x, mask_.cols) / kTile + 1;
  const int* const above = allowed_tiles_.ptr<int>(nearestPixel(first.y, mask_.rows) / kTile);
  const int* const below = allowed_tiles_.ptr<int>(nearestPixel(last.y, mask_.rows) / kTile + 1);
  return below[right] - below[left] - above[right] + above[left] > 0;
}

void PlaceMask::apply(Features& features) const {
  if (everywhere()) return;
  std::vector<char> keep;
  keep.reserve(features.keypoints.size());
  for (const cv::KeyPoint& keypoint : features.keypoints) keep.push_back(allows(keypoint.pt) ? 1 : 0);
  keepFeatures(keep, features);
}

}  // namespace corrsel::core
