#pragma once

#include <cstddef>
#include <vector>

#include "corrsel/correspondences.h"
#include "features/parts/scale_level.h"
#include "kernels/patch.h"

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
/// (columns) from -Patch::kHalf to Patch::kHalf. Beyond the border the nearest pixel is used.
/// @param level    at least 2 x 2 pixels
/// @param spacing  of the samples, in units of the frame
/// @return the number of samples beyond the border
int samplePatch(const ScaleLevel& level, const AffineFrame& frame, double spacing, Patch& patch);

/// As samplePatch() and PatchKernels::filter() with the samples as input, in less time.
/// @param frame  of equal half axes along x and y
/// @param sums   receives PatchFilters::kCount values
void filterPatch(const ScaleLevel& level, const AffineFrame& frame, double spacing,
                 const PatchFilters& filters, float* sums);

/// Weights exp(-d^2 / (2 sigma^2)) of the gradients of a patch, where d is the distance to the centre.
/// @param sigma  samples
PatchWeights gaussianWindow(double sigma);

}  // namespace corrsel::core
