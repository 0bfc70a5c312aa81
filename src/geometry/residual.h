#pragma once

#include <opencv2/core/matx.hpp>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
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

/// Squared tangent Sampson errors of re-paired matches, px^2: out[i] is that of the left ray of match i and
/// the right ray of match (i + shift) mod N. If the matches are in random order, these are the errors of
/// outliers.
/// @pre shift < N
void repairedErrors(const cv::Matx33d& essential, const RayColumns& rays, std::size_t shift, float* out);

/// Squared errors of all matches in double precision, in pixels, of a homography or a fundamental matrix.
void pixelErrors(Residual residual, const cv::Matx33d& model, const Correspondences& matches, double* out);

/// Whether a point has one image under models of this kind.
inline bool mapsPoints(ModelKind kind) {
  return kind == ModelKind::kHomography || kind == ModelKind::kRotation;
}

/// Squared errors of rays under an essential matrix or a rotation, px^2; NaN where a ray does not exist.
void rayErrors(ModelKind kind, const cv::Matx33d& model, const RayMatches& rays, std::vector<double>& errors);

/// Squared errors of all matches under the model of a selection, px^2: the smaller transfer error, the
/// Sampson distance, the tangent Sampson error or the error of a rotation. NaN where a ray does not exist.
/// @param rays    memory, for models of rays
/// @pre the kind is not kNone; for models of rays, both cameras are given
void selectionErrors(ModelKind kind, const cv::Matx33d& model, const Correspondences& matches,
                     RayMatches& rays, std::vector<double>& errors);

}  // namespace corrsel::core
