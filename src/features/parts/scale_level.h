#pragma once

#include <cstddef>
#include <cstdint>

namespace corrsel::core {

/// The blur that an image is assumed to have when it is taken, sigma in px (Lowe, IJCV 2004, section 3.3).
inline constexpr double kCameraBlur = 0.5;

/// Pixel values of a scale space per grey level: 255 becomes 32640, and differences of two pixels fit 16
/// bits. With half as many, rounding would move a percent of the extrema.
inline constexpr int kGreyUnit = 128;

/// One level of a Gaussian scale space. Its pixel (i, j) shows the image at (offset + i * step, offset + j *
/// step).
struct ScaleLevel {
  const std::int16_t* pixels = nullptr;  ///< row-major, kGreyUnit * grey level
  std::ptrdiff_t stride = 0;             ///< pixels from one row to the next, at least the width
  int width = 0, height = 0;             ///< in pixels of the level
  double step = 1;                       ///< distance between two pixels of the level, px of the image
  double sigma = 0;                      ///< total blur, including that of the camera, px of the image
  double offset = 0;                     ///< of the first pixel, px of the image; -0.25 where it was doubled
};

}  // namespace corrsel::core
