#pragma once

#include <cstddef>
#include <vector>

#include "corrsel/correspondences.h"
#include "features/parts/scale_level.h"

namespace corrsel::core {

/// The most blurred level whose blur is at most sigma, or the least blurred level where there is none.
/// @param levels  in the order of sigma, at least one
const ScaleLevel& levelFor(const std::vector<ScaleLevel>& levels, double sigma);

/// The half axes of the ellipse to which a frame maps the unit disc, px.
struct HalfAxes {
  double smaller, larger;
};
HalfAxes halfAxes(const AffineFrame& frame);

/// Samples a level bilinearly at the image points frame * (c * spacing, r * spacing), for r (rows) and c
/// (columns) from -half to half. Beyond the border the nearest pixel is used. O(samples).
/// @param level   at least 2 x 2 pixels
/// @param spacing  of the samples, in units of the frame
/// @param patch   receives (2 half + 1)^2 grey levels, row-major
/// @return the number of samples beyond the border
std::size_t samplePatch(const ScaleLevel& level, const AffineFrame& frame, int half, double spacing,
                        float* patch);

/// Weights exp(-d^2 / (2 sigma^2)) of the samples of a patch, where d is the distance to the centre.
/// @param half    as in samplePatch()
/// @param spacing  of the samples, in the unit of sigma
/// @return (2 half + 1)^2 weights, row-major
std::vector<float> gaussianWindow(int half, double spacing, double sigma);

}  // namespace corrsel::core
