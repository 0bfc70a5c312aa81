#pragma once

#include "features/detectors/opencv_detector.h"

namespace corrsel::core {

struct AkazeOptions : DetectorOptions {
  double threshold = 0.001;  ///< smallest determinant of the Hessian
  int octaves = 4;           ///< of the non-linear scale space
  int octave_layers = 4;     ///< layers per octave

  void visit(OptionVisitor& visitor) const override;
};

/// "akaze": OpenCV's AKAZE with its M-LDB descriptor.
///
/// Idea: A scale space that is blurred less across edges than along them keeps edges sharp, so blobs and
/// corners are located better than in a Gaussian scale space.
///
/// Algorithm: Non-linear diffusion, extrema of the determinant of the Hessian over space and scale, and
/// binary comparisons of mean intensities and gradients on grids around the keypoint.
///
/// Input: 8-bit grey image. The descriptor needs the scale space and describes only the detector's own
/// keypoints.
///
/// Options: AkazeOptions. OpenCV cannot limit the number of features, so `max_features` is applied
/// afterwards.
///
/// Failure: Images whose width or height is at most 32 px have no features.
///
/// Cost: O(pixels).
///
/// Source: Alcantarilla, Nuevo and Bartoli, "Fast Explicit Diffusion for Accelerated Features in Nonlinear
/// Scale Spaces", BMVC 2013; implementation: OpenCV's features2d.
class AkazeDetector : public OpenCvDetector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit AkazeDetector(const AkazeOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 private:
  AkazeOptions options_;
};

}  // namespace corrsel::core
