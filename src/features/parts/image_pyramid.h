#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/workspace.h"

namespace corrsel::core {

/// A level of an image pyramid, 8-bit grey levels. 64 bytes behind each of its pixels may be read.
struct PyramidLevel {
  const std::uint8_t* pixels;
  std::ptrdiff_t stride;    ///< bytes from row to row
  int width, height;        ///< px of the level
  double scale;             ///< a pixel of the level, px of the image: scale_factor^level
  double x_scale, y_scale;  ///< the same, with the rounding of width and height to whole pixels

  /// From pixels of the level to those of the image. The centre of the upper left pixel is (0, 0) in both.
  cv::Point2f toImage(int x, int y) const {
    return {static_cast<float>((x + 0.5) * x_scale - 0.5), static_cast<float>((y + 0.5) * y_scale - 0.5)};
  }

  /// The nearest pixel of the level; it may lie outside.
  cv::Point fromImage(const cv::Point2f& p) const;
};

/// An image, and the same image reduced again and again by a constant factor.
///
/// Algorithm: A level is interpolated bilinearly from the level before. For descriptors, each level is
/// blurred by a Gaussian with a sigma of 2 px and 7 taps. All sums are whole numbers.
///
/// Cost: O(pixels) time and about 2 scale_factor^2 / (scale_factor^2 - 1) bytes per pixel, which are kept for
/// the next image.
class ImagePyramid {
 public:
  static constexpr int kBlurReach = 3;  ///< of the taps of the blur, px

  /// Begins with a new image. The levels are then made by calls of reduce(), in their order.
  /// @param levels  at least 1; the smallest level must have at least 2 px to each side
  /// @param blur    whether blur() will be called
  void start(const cv::Mat& grey, double scale_factor, int levels, bool blur);

  int size() const { return static_cast<int>(levels_.size()); }

  /// @pre the level is made
  const PyramidLevel& level(int number) const { return levels_[static_cast<std::size_t>(number)].image; }

  /// Makes a level. @pre the level before is made
  void reduce(int number, Workspace& workspace);

  /// Blurs a part of a level. Several threads, each with its own workspace, may blur different parts.
  /// @pre the level is made and has kBlurReach more pixels on each side of the part
  void blur(int number, const cv::Rect& part, Workspace& workspace);

  /// The level, blurred where blur() was called.
  PyramidLevel blurred(int number) const;

 private:
  struct Level {
    PyramidLevel image;
    std::vector<std::uint8_t> pixels, blurred;
  };

  std::vector<Level> levels_;
};

/// The number of levels, at most `max_levels`, whose shorter side is above `border` + 1 px; at least 1.
int usableLevels(const cv::Size& image_size, double scale_factor, int max_levels, int border);

/// Divides a number of features among levels in proportion to their sides: a geometric series, as in ORB.
std::vector<int> levelShares(int features, double scale_factor, int levels);

}  // namespace corrsel::core
