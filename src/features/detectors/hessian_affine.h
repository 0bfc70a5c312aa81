#pragma once

#include "features/detectors/detector.h"

namespace corrsel::core {

/// The defaults are common ones of Hessian-affine detectors, except for the first octave.
struct HessianAffineOptions : DetectorOptions {
  double peak_threshold = 0.003;  ///< smallest determinant of the Hessian, of grey values from 0 to 1
  double edge_threshold = 10.0;   ///< largest ratio of the principal curvatures
  double scale_threshold = 0.01;  ///< smallest Laplacian at the chosen scale, of grey values from 0 to 1
  int first_octave = 0;           ///< -1 doubles the image first: smaller features, 2 to 4 times the time
  int octave_resolution = 3;      ///< levels per octave
  bool adapt = true;              ///< to the affine shape; else the frames are similarities
  int max_orientations = 4;       ///< features with one position and shape
  double overlap = 0.5;           ///< features nearer than this times the stronger one's scale are dropped
  double margin = 1.0;            ///< of the frame that must lie inside the image, in units of the frame

  void visit(OptionVisitor& visitor) const override;
};

/// "hessian_affine": Hessian-Laplace keypoints with an affine shape.
///
/// Idea: Blobs are located where the Hessian is extremal, their scale is where the Laplacian is extremal, and
/// the second moments of the gradients around them give an elliptic shape that follows changes of viewpoint.
///
/// Algorithm: Extrema of the determinant of the Hessian in every level of a Gaussian scale space, refined by
/// a quadratic, are kept where the Laplacian has an extremum over scale. The strongest are processed first.
/// The shape A is iterated until the second moment matrix M of the patch that it spans is a multiple of the
/// identity: A A' <- A M^-1 A'. The smaller half axis stays at the scale that was found, and the iteration
/// stops beyond a ratio of the half axes of 5. The direction is that of the strongest gradients in the
/// normalised patch. One unit of a frame is the scale sigma; the keypoint's size is 2 sqrt(|det A|), and its
/// response is |determinant of the Hessian|.
///
/// Input: 8-bit grey image.
///
/// Options: HessianAffineOptions.
///
/// Failure: Images whose smaller side is below 16 px (16 * 2^first_octave px where first_octave > 0) have no
/// features. std::bad_alloc is thrown where the memory does not suffice.
///
/// Cost: 8 bytes per pixel (32 with first_octave = -1), which are kept for the next image, and about 30 ms
/// for 3000 features of 0.5 megapixels on one thread. With max_features and without spread, only the
/// strongest features get scales, shapes and directions. Masked features save the time of their shapes and
/// directions.
///
/// Source: Mikolajczyk and Schmid, "Scale & Affine Invariant Interest Point Detectors", IJCV 2004; shape:
/// Lindeberg and Garding, IVC 1997, and Baumberg, CVPR 2000; direction: Lowe, IJCV 2004, section 5.
class HessianAffineDetector : public Detector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit HessianAffineDetector(const HessianAffineOptions& options = {});

  void detect(const DetectionRequest& request, Features& features) const override;
  std::string name() const override { return "hessian_affine"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  HessianAffineOptions options_;
};

}  // namespace corrsel::core
