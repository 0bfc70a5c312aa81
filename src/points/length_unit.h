#pragma once

#include <algorithm>
#include <cmath>
#include <opencv2/core/types.hpp>
#include <vector>

namespace corrsel::core {

/// The unit of lengths that follow the size of an image, px: its diagonal divided by 1250, so 1 px for an
/// image of 1000 x 750.
///
/// Two kinds of lengths are told apart:
///  - The accuracy of features, in px: thresholds and tolerances. Features are found again within about half
///    a pixel or some pixels in images of any size. Those that matter to a user are options.
///  - Everything else, in this unit: what counts as the same place, how far a neighbourhood reaches, how far
///    structure repeats. The same scene in an image of another size then gives the same answer, apart from
///    the accuracy of the features. A few lengths have a lower bound in px as well, see atLeast().
/// @param image  its size, px; where it is unknown, the extent of the points takes its place
/// @param x, y   the points in it
inline double lengthUnit(const cv::Size& image, const std::vector<float>& x, const std::vector<float>& y) {
  constexpr double kShareOfDiagonal = 0.8e-3, kMin = 0.05;
  double width = image.width, height = image.height;
  if ((image.width <= 0 || image.height <= 0) && !x.empty()) {
    const auto [low_x, high_x] = std::minmax_element(x.begin(), x.end());
    const auto [low_y, high_y] = std::minmax_element(y.begin(), y.end());
    width = static_cast<double>(*high_x) - *low_x;
    height = static_cast<double>(*high_y) - *low_y;
  }
  return std::max(kMin, kShareOfDiagonal * std::hypot(width, height));
}

/// The units of the left and the right image.
struct LengthUnits {
  double left = 1, right = 1;  ///< px

  template <class Matches>
  static LengthUnits of(const Matches& m) {
    return {lengthUnit(m.left_size, m.left_x, m.left_y), lengthUnit(m.right_size, m.right_x, m.right_y)};
  }

  /// Units that are not smaller than `px`, for lengths below which the pixels themselves repeat: the blocks
  /// of JPEG have 8 px in an image of any size.
  LengthUnits atLeast(double px) const { return {std::max(px, left), std::max(px, right)}; }
};

}  // namespace corrsel::core
