#pragma once

#include <string>

#include "features/detectors/detector.h"

namespace corrsel::core {

struct SiftOptions : DetectorOptions {
  int first_octave = -1;             ///< -1 doubles the image; 0 finds none below 2 px, 3 to 4 times as fast
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers internally
  double edge_threshold = 10.0;      ///< edge-like extrema are dropped; larger keeps more
  double sigma = 1.6;                ///< blur of the first level of an octave, px of the octave
  bool root = false;                 ///< RootSIFT; the one option that only the descriptor uses

  void visit(OptionVisitor& visitor) const override;
};

/// "sift": detector and descriptor.
///
/// Idea: Extrema of the difference of Gaussians over space and scale are found again after changes of scale,
/// rotation and brightness.
///
/// Algorithm: Extrema of differences of Gaussians (DogKeypoints), one feature for every dominant direction of
/// the gradients around them, and 4 x 4 x 8 histograms of gradients (siftDescriptor()), i.e. 128 whole
/// numbers from 0 to 255. With `root` the descriptors pass through toRootSift(). A keypoint's size is twice
/// its scale, its response is its contrast, and its octave is packed as OpenCV's SIFT packs it: octave + 256
/// * level + 65536 * (part of a level + 0.5) * 255.
///
/// Agreement with OpenCV's SIFT: On the first images of VGG, 97 % of OpenCV's keypoints are found within half
/// a pixel and 10 % of their scale, and 96 % of the keypoints here are OpenCV's. Positions differ by a
/// quarter of a pixel in x and y, because OpenCV does not correct for the shift of the doubled image.
///
/// Input: 8-bit grey image.
///
/// Options: SiftOptions. With max_features, directions and descriptors are only computed for the strongest
/// features, and the result is the same.
///
/// Failure: Images whose width or height is at most 5 px (10 px with first_octave = 0) have no features.
///
/// Cost: 65 bytes per pixel (16 with first_octave = 0), which are kept for the next image. On one core with
/// AVX2 about 30 ns per pixel and 4 us per feature. Rows and features are distributed over threads.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004.
class SiftDetector : public Detector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit SiftDetector(const SiftOptions& options = {});

  void detect(const DetectionRequest& request, Features& features) const override;
  bool describesKeypoints() const override { return true; }
  std::string name() const override { return "sift"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  SiftOptions options_;
};

}  // namespace corrsel::core
