#pragma once

#include <string>
#include <vector>

#include "features/detectors/detector.h"
#include "features/parts/oriented_patch.h"

namespace corrsel::core {

/// Diameter of the circle of pixels that FAST looks at, px.
inline constexpr double kFastDiameter = 7;

struct OrbOptions : DetectorOptions {
  double scale_factor = 1.2;  ///< between pyramid levels
  int levels = 8;             ///< of the pyramid
  int fast_threshold = 20;    ///< smallest corner contrast, grey levels
  int patch_size = 31;        ///< of the descriptor, px; features closer than this to the border are lost

  OrbOptions() { max_features = 5000; }
  void visit(OptionVisitor& visitor) const override;
};

/// "orb": oriented FAST and rotated BRIEF, detector and descriptor.
///
/// Idea: The corner test FAST is the cheapest there is; a pyramid and an orientation make its corners usable
/// under changes of scale and rotation.
///
/// Algorithm: On every level of an ImagePyramid, a corner is a pixel with nine contiguous pixels on its
/// circle of 16 that are all brighter, or all darker, by more than fast_threshold. Of neighbouring corners,
/// the one with the largest contrast is kept. The response is Harris' measure det(M) - 0.04 trace(M)^2, with
/// M the sums of products of Sobel derivatives over 7 x 7 px, of grey values from 0 to 1. OrientedPatch
/// computes the angle and the descriptor.
///
/// Input: 8-bit grey image.
///
/// Options: OrbOptions. `max_features` is divided among the levels in proportion to their sides, unless
/// `spread` is set; each level keeps its strongest corners. With another descriptor the size of a keypoint is
/// the diameter of FAST's circle (7 px times the scale) instead of the patch size.
///
/// Output: A keypoint's octave is the number of its level. Descriptors have 32 bytes.
///
/// Failure: Images whose width or height is at most 2 patch_size have no features.
///
/// Cost: O(pixels), in parallel over levels, bands of rows, and features. Bands without allowed places are
/// not searched; features that max_features drops get neither an angle nor a descriptor.
///
/// Source: Rublee, Rabaud, Konolige and Bradski, "ORB: an efficient alternative to SIFT or SURF", ICCV 2011;
/// corners: Rosten and Drummond, "Machine learning for high-speed corner detection", ECCV 2006.
class OrbDetector : public Detector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit OrbDetector(const OrbOptions& options = {});

  /// Features are sorted, strongest first.
  void detect(const DetectionRequest& request, Features& features) const override;
  bool describesKeypoints() const override { return true; }
  std::string name() const override { return "orb"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  OrbOptions options_;
  OrientedPatch patch_;
};

}  // namespace corrsel::core
