#pragma once

#include <string>

#include "features/detectors/detector.h"

namespace corrsel::core {

struct AsiftOptions : DetectorOptions {
  int tilts = 5;                     ///< simulated tilts sqrt(2)^k, k = 1..tilts, beside the image itself
  double rotation_step = 72;         ///< between the views of tilt t: this / t, degrees
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers inside
  double edge_threshold = 10;        ///< edge-like extrema are dropped; larger keeps more
  double sigma = 1.6;           ///< blur of the first octave, px; smaller finds more and smaller features
  double margin = 6;            ///< simulated views: least distance from the border, keypoint radii
  double merge_distance = 0.5;  ///< see the class; in the stronger one's frame, keypoint radii
  double merge_shape = 0.4;     ///< see the class

  AsiftOptions() { max_megapixels = 4; }
  void visit(OptionVisitor& visitor) const override;
};

/// Affine SIFT (Morel and Yu, SIAM J. Imaging Sciences 2009; Yu and Morel, IPOL 2011): SIFT in views of the
/// image that simulate a tilted camera. A view of tilt t is the image turned by one of 180 t / rotation_step
/// angles, blurred by 0.8 sqrt(t^2 - 1) px across one axis and compressed by t along it. Keypoints of
/// simulated views nearer than `margin` radii to the image's border are dropped, as the view ends there.
///
/// A frame is the view's similarity frame (radius = scale) taken back to the image, so that it carries the
/// tilt; keypoint sizes are 2 sqrt(|det|) of it, class_id is the number of the view (0 = the image), octave
/// that of SIFT inside the view.
///
/// Views of one keypoint are merged: a feature with frame B at q is dropped where a stronger one with frame A
/// at p has |A^-1 (q - p)| <= merge_distance and |A^-1 B - I| <= merge_shape (Frobenius norm). Features seen
/// under clearly different tilts remain, since their descriptors differ: they are what matches a strong
/// change of viewpoint. Both options 0: hardly anything is merged.
///
/// About 2.5 tilts + 1 times the work of SIFT on the image, in parallel over views; 48 bytes per pixel of the
/// largest view (twice the image's pixels) and thread.
class AsiftDetector : public SelfDescribingDetector {
 public:
  explicit AsiftDetector(const AsiftOptions& options = {});

  /// Keypoints and frames, strongest first.
  void detect(const cv::Mat& grey, int threads, Features& features) const override;

  /// As detect(), and descriptors: SIFT computed in the view, N x 128, CV_32F with whole numbers 0..255.
  void detectAndDescribe(const cv::Mat& grey, int threads, Features& features) const override;

  std::string name() const override { return "asift"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  AsiftOptions options_;
};

}  // namespace corrsel::core
