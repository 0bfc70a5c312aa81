#pragma once

#include <string>

#include "features/detectors/detector.h"

namespace corrsel::core {

struct AsiftOptions : DetectorOptions {
  int tilts = 5;                     ///< simulated tilts sqrt(2)^k, k = 1..tilts, beside the image itself
  double rotation_step = 72;         ///< between the views of tilt t: this / t, degrees
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers internally
  double edge_threshold = 10;        ///< edge-like extrema are dropped; larger keeps more
  double sigma = 1.6;           ///< blur of the first octave, px; smaller finds more and smaller features
  double margin = 6;            ///< simulated views: smallest distance from the border, keypoint radii
  double merge_distance = 0.5;  ///< see Merging below, keypoint radii
  double merge_shape = 0.4;     ///< see Merging below

  AsiftOptions() { max_megapixels = 4; }
  void visit(OptionVisitor& visitor) const override;
};

/// "asift": affine SIFT, detector and descriptor.
///
/// Idea: SIFT withstands changes of scale and rotation. Views of the image from tilted cameras are simulated,
/// and SIFT in these views also withstands strong changes of viewpoint.
///
/// Algorithm: A view of tilt t = sqrt(2)^k, k = 1..tilts, is the image rotated by one of 180 t /
/// rotation_step angles, blurred by 0.8 sqrt(t^2 - 1) px along one axis and compressed by t along this axis;
/// see TiltedViews. The features of a view are those of "sift" with first_octave = 0. A frame is the
/// similarity frame of the view (radius = scale) mapped back to the image, so it carries the tilt. A
/// keypoint's size is 2 sqrt(|det|) of its frame, its class_id is the number of the view (0 = the image
/// itself), and its octave is SIFT's octave in the view.
///
/// Merging: Several views may find the same keypoint. A feature with frame B at q is dropped where a stronger
/// one with frame A at p has |A^-1 (q - p)| <= merge_distance and |A^-1 B - I| <= merge_shape (Frobenius
/// norm). Features found under clearly different tilts remain, since their descriptors differ; these are the
/// ones that match after a strong change of viewpoint. With both options 0 hardly anything is merged.
///
/// Input: 8-bit grey image.
///
/// Options: AsiftOptions. Keypoints of simulated views closer than `margin` radii to the border of the image
/// are dropped, because the view ends there.
///
/// Failure: Images whose width or height is below 11 px have no features.
///
/// Cost: About 2.5 tilts + 1 times the work of "sift" with first_octave = 0 on the image, in parallel over
/// views. 16 bytes per pixel of the largest view (1.5 times the image's pixels) and thread are kept for the
/// next image.
///
/// Source: Morel and Yu, "ASIFT: A New Framework for Fully Affine Invariant Image Comparison", SIAM J.
/// Imaging Sciences 2009; Yu and Morel, IPOL 2011.
class AsiftDetector : public Detector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit AsiftDetector(const AsiftOptions& options = {});

  /// Features are sorted, strongest first. Descriptors are SIFT's, computed in the view: N x 128, CV_32F,
  /// whole numbers from 0 to 255.
  void detect(const DetectionRequest& request, Features& features) const override;
  bool describesKeypoints() const override { return true; }
  std::string name() const override { return "asift"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  AsiftOptions options_;
};

}  // namespace corrsel::core
