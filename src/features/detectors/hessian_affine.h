#pragma once

#include "features/detectors/detector.h"

namespace corrsel::core {

/// The defaults are VLFeat's, but for the first octave.
struct HessianAffineOptions : DetectorOptions {
  double peak_threshold = 0.003;  ///< smallest determinant of the Hessian, of grey values from 0 to 1
  double edge_threshold = 10.0;   ///< largest ratio of the principal curvatures
  double scale_threshold = 0.01;  ///< smallest Laplacian at the chosen scale, of grey values from 0 to 1
  int first_octave = 0;           ///< -1 doubles the image first: smaller features, 4 times the time
  int octave_resolution = 3;      ///< levels per octave
  bool adapt = true;              ///< to the affine shape; else the frames are similarities
  int max_orientations = 4;       ///< features with one position and shape
  double overlap = 0.5;           ///< features nearer than this times the stronger one's scale are dropped
  double margin = 1.0;            ///< of the frame that must lie inside the image, in units of the frame

  void visit(OptionVisitor& visitor) const override;
};

/// "hessian_affine" (Mikolajczyk and Schmid, IJCV 2004): extrema of the determinant of the Hessian in every
/// level of a Gaussian scale space (VLFeat's covdet), kept where the Laplacian has an extremum over scale;
/// the affine shape by iterating the second moment matrix (Lindeberg and Garding, IVC 1997; Baumberg, CVPR
/// 2000), and the direction of the strongest gradients (Lowe, IJCV 2004, section 5). The shape keeps its
/// smaller half axis at the scale that was found and is left alone beyond a ratio of 5. One unit of a frame
/// is the scale sigma; the keypoint's size is 2 sqrt(|det A|), its response |determinant of the Hessian|.
///
/// No features in images whose smaller side is below 16 px (16 * 2^first_octave px for higher octaves). 45
/// bytes per pixel (180 with first_octave = -1) and about 0.3 s for 3000 features of 0.5 megapixels on one
/// thread, of which the scale space and its extrema, a third, are not shared among threads. Throws
/// std::bad_alloc when memory ends.
class HessianAffineDetector : public Detector {
 public:
  explicit HessianAffineDetector(const HessianAffineOptions& options = {});

  void detect(const cv::Mat& grey, int threads, Features& features) const override;
  /// Saves the time of adaptation and orientation of what is refused.
  void detectWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                   Features& features) const override;
  std::string name() const override { return "hessian_affine"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  HessianAffineOptions options_;
};

}  // namespace corrsel::core
