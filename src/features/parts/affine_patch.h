#pragma once

#include <cstddef>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// One level of a Gaussian scale space. Pixel (i, j) shows the image at (i * step, j * step).
struct ScaleLevel {
  const float* pixels = nullptr;  ///< row-major, rows follow each other without gaps
  int width = 0, height = 0;      ///< in pixels of the level
  double step = 1;                ///< distance of two pixels of the level, px of the image
  double sigma = 0;               ///< blur against the scene, px of the image
};

/// The most blurred level with at most the given blur, else the least blurred one.
/// @param levels  in order of sigma, at least one
const ScaleLevel& levelFor(const std::vector<ScaleLevel>& levels, double sigma);

/// The half axes of the ellipse that a frame maps the unit disc to: the smaller one first, px.
struct HalfAxes {
  double smaller, larger;
};
HalfAxes halfAxes(const AffineFrame& frame);

/// Samples the level bilinearly at the image points frame * (c * spacing, r * spacing), for r (rows) and c
/// from -half to half; beyond the border the image goes on with its nearest pixel.
/// @param level    2 x 2 pixels or more
/// @param spacing  of the samples, in units of the frame
/// @param patch    (2 half + 1)^2 values, row-major
/// @return the number of samples beyond the border
std::size_t samplePatch(const ScaleLevel& level, const AffineFrame& frame, int half, double spacing,
                        float* patch);

/// Length and direction of n gradients; the direction in [0, turn), counted from +x to +y.
/// @param turn  what a full turn is to be, e.g. 2 pi or the number of histogram bins. Error below 2e-6 turns.
void polarGradients(const float* dx, const float* dy, std::size_t n, float turn, float* length,
                    float* direction);

}  // namespace corrsel::core
