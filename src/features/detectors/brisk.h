#pragma once

#include "features/detectors/opencv_detector.h"

namespace corrsel::core {

struct BriskOptions : DetectorOptions {
  int threshold = 30;          ///< smallest corner contrast, grey levels
  int octaves = 3;             ///< of the pyramid
  double pattern_scale = 1.0;  ///< of the descriptor's sampling pattern

  void visit(OptionVisitor& visitor) const override;
};

/// Border inside which BRISK finds nothing, px.
inline constexpr int kBriskBorder = 8;

/// The size of OpenCV's BRISK keypoints on the first level, and the diameter of the circle of pixels that its
/// corner test AGAST looks at, px.
inline constexpr double kBriskSize = 12, kAgastDiameter = 7;

/// OpenCV's BRISK with as many octaves as the image allows.
CreateOpenCv briskCreator(const BriskOptions& options);

/// "brisk": OpenCV's BRISK, detector and descriptor.
///
/// Idea: Corners are found fast and at a continuous scale, by the corner test of AGAST on a pyramid with
/// levels between the octaves.
///
/// Algorithm: AGAST 9-16 on octaves and intra-octaves, non-maximum suppression over position and scale, and
/// quadratic interpolation of the corner score over scale. The descriptor is BriskDescriptor's.
///
/// Input: 8-bit grey image.
///
/// Options: BriskOptions. OpenCV cannot limit the number of features, so `max_features` is applied
/// afterwards. With another descriptor the size of a keypoint is the diameter of the corner test's circle (7
/// px times the scale) instead of the size of BRISK's own patch.
///
/// Failure: Images whose width or height is at most 16 px have no features.
///
/// Cost: O(pixels).
///
/// Source: Leutenegger, Chli and Siegwart, "BRISK: Binary Robust Invariant Scalable Keypoints", ICCV 2011;
/// implementation: OpenCV's features2d.
class BriskDetector : public OpenCvDetector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit BriskDetector(const BriskOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 private:
  BriskOptions options_;
};

}  // namespace corrsel::core
