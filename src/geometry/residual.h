#pragma once

#include <opencv2/core/matx.hpp>

#include "corrsel/correspondences.h"
#include "geometry/normalization.h"
#include "kernels/kernels.h"

namespace corrsel::core {

/// Converts a homography or fundamental matrix to the form that the kernels read. With
/// Residual::kSymmetricTransfer and kSmallerTransfer, a homography without an inverse gets a backward mapping
/// under which every error is infinite.
ResidualModel residualModel(Residual residual, const cv::Matx33d& model);

/// Squared errors of matches [begin, end) in single precision, in the unit of the coordinates squared,
/// written to out[0 .. end - begin); +Inf if the point lies behind a camera.
void modelErrors(Residual residual, const cv::Matx33d& model, const NormalizedMatches& matches,
                 std::size_t begin, std::size_t end, float* out);

/// Squared errors of all matches in double precision, in pixels. They decide the mask of a selection.
void pixelErrors(Residual residual, const cv::Matx33d& model, const Correspondences& matches, double* out);

}  // namespace corrsel::core
