#pragma once

#include <limits>

namespace corrsel::core {

/// What an image suffers from, as numbers. NaN = not measured.
struct ImageQuality {
  double black = std::numeric_limits<double>::quiet_NaN();      ///< share of the pixels without light, 0..1
  double saturated = std::numeric_limits<double>::quiet_NaN();  ///< share of the pixels at full scale, 0..1
  /// Width of the edges: standard deviation of the Gaussian that would blur sharp ones as much, px.
  double blur = std::numeric_limits<double>::quiet_NaN();
  /// `blur` divided by that of the sharp images of the last seconds: 1 = as sharp as those.
  double relative_blur = std::numeric_limits<double>::quiet_NaN();
  double noise = std::numeric_limits<double>::quiet_NaN();    ///< standard deviation of a pixel, of 255
  double texture = std::numeric_limits<double>::quiet_NaN();  ///< share of cells of 8 x 8 with features, 0..1
};

}  // namespace corrsel::core
