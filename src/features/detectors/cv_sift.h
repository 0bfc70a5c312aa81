#pragma once

#include <string>
#include <vector>

#include "features/detectors/opencv_detector.h"

namespace corrsel::core {

struct CvSiftOptions : DetectorOptions {
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers internally
  double edge_threshold = 10.0;      ///< edge-like extrema are dropped; larger keeps more
  double sigma = 1.6;                ///< blur of the first octave, px
  bool root = false;                 ///< RootSIFT

  void visit(OptionVisitor& visitor) const override;
};

/// Throws std::invalid_argument where this version of OpenCV is older than 4.4, the first one whose main
/// modules contain SIFT. The message names the version and the remedy.
/// @param algorithm  the name of the algorithm that needs SIFT
void requireCvSift(const std::string& algorithm, int major, int minor, int revision);

/// "cv_sift": OpenCV's SIFT, detector and descriptor. It is there to compare "sift" with.
///
/// Idea: Extrema of the difference of Gaussians over space and scale are found again after changes of scale,
/// rotation and brightness.
///
/// Algorithm: Difference-of-Gaussian scale space of the doubled image, extrema refined by a quadratic fit,
/// edges rejected by the ratio of principal curvatures, one feature per dominant gradient direction, and 4 x
/// 4 x 8 histograms of gradients (128 whole numbers from 0 to 255). With `root` the descriptors pass through
/// toRootSift().
///
/// Input: 8-bit grey image.
///
/// Options: CvSiftOptions. OpenCV keeps the strongest max_features itself, unless `spread` is set.
///
/// Failure: Images whose width or height is at most 8 px have no features. With an OpenCV older than 4.4 the
/// constructor throws.
///
/// Cost: O(pixels), up to 240 bytes per pixel.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004; implementation:
/// OpenCV's features2d.
class CvSiftDetector : public OpenCvDetector {
 public:
  /// Throws std::invalid_argument for options out of range, and where requireCvSift() does.
  explicit CvSiftDetector(const CvSiftOptions& options = {});
  void detect(const DetectionRequest& request, Features& features) const override;
  const DetectorOptions& options() const override { return options_; }

 protected:
  std::vector<int> shares(const cv::Size& image_size, int max_features) const override;

 private:
  CvSiftOptions options_;
};

}  // namespace corrsel::core
