#pragma once

#include <vector>

#include "features/detectors/opencv_detector.h"

namespace corrsel::core {

struct CvOrbOptions : DetectorOptions {
  double scale_factor = 1.2;  ///< between pyramid levels
  int levels = 8;             ///< of the pyramid
  int fast_threshold = 20;    ///< smallest corner contrast, grey levels
  int patch_size = 31;        ///< of the descriptor, px; features closer than this to the border are lost

  CvOrbOptions() { max_features = 5000; }
  void visit(OptionVisitor& visitor) const override;
};

/// "cv_orb": OpenCV's ORB, detector and descriptor. It is there to compare "orb" with.
///
/// Idea: The corner test FAST is the cheapest there is; a pyramid and an orientation make its corners usable
/// under changes of scale and rotation.
///
/// Algorithm: FAST 9-16 on every level; the Harris score ranks the corners; the direction points from the
/// corner to the intensity centroid of its patch. The descriptor compares 256 learned pairs of pixels of the
/// smoothed patch, rotated by this direction.
///
/// Input: 8-bit grey image.
///
/// Options: CvOrbOptions. `max_features` is divided among the levels in proportion to their sides, unless
/// `spread` is set. With another descriptor the size of a keypoint is the diameter of FAST's circle (7 px
/// times the scale) instead of the patch size.
///
/// Failure: Images whose width or height is at most 2 patch_size have no features.
///
/// Cost: O(pixels).
///
/// Source: Rublee, Rabaud, Konolige and Bradski, "ORB: an efficient alternative to SIFT or SURF", ICCV 2011;
/// implementation: OpenCV's features2d.
class CvOrbDetector : public OpenCvDetector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit CvOrbDetector(const CvOrbOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 protected:
  std::vector<int> shares(const cv::Size& image_size, int max_features) const override;

 private:
  CvOrbOptions options_;
};

}  // namespace corrsel::core
