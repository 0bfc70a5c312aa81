#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "features/parts/opencv_features.h"

namespace corrsel::core {

/// SIFT (Lowe, IJCV 2004) as in OpenCV's features2d.
struct SiftOptions : DetectorOptions {
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers inside
  double edge_threshold = 10.0;      ///< edge-like extrema are dropped; larger keeps more
  double sigma = 1.6;                ///< blur of the first octave, px
  bool root = false;                 ///< RootSIFT; the one option that the descriptor alone uses

  void visit(OptionVisitor& visitor) const override;
};

/// "sift".
class SiftDetector : public OpenCvDetector {
 public:
  explicit SiftDetector(const SiftOptions& options = {});
  void detectAndDescribe(const cv::Mat& grey, int threads, Features& features) const override;
  void detectAndDescribeWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                              Features& features) const override;
  const DetectorOptions& options() const override { return options_; }

 protected:
  std::vector<int> shares(const cv::Size& image_size, int most) const override;

 private:
  SiftOptions options_;
};

/// RootSIFT (Arandjelovic and Zisserman, CVPR 2012, section 3): square roots of every row divided by its sum,
/// so that L2 compares as the Hellinger kernel does. Times 512 and rounded to whole numbers from 0 to 255, as
/// SIFT is. @param descriptors  N x 128 CV_32F, not negative
void toRootSift(cv::Mat& descriptors);

}  // namespace corrsel::core
