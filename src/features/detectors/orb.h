#pragma once

#include <memory>
#include <vector>

#include "features/parts/opencv_features.h"

namespace corrsel::core {

/// ORB (Rublee et al., ICCV 2011) as in OpenCV's features2d.
struct OrbOptions : DetectorOptions {
  double scale_factor = 1.2;  ///< between pyramid levels
  int levels = 8;             ///< of the pyramid
  int fast_threshold = 20;    ///< smallest corner contrast, grey levels
  int patch_size = 31;        ///< of the descriptor, px; features closer than this to the border are lost

  OrbOptions() { max_features = 5000; }
  void visit(OptionVisitor& visitor) const override;
};

/// "orb". Hands max_features out over the levels of the pyramid in proportion to their sides, unless they are
/// to be spread.
class OrbDetector : public OpenCvDetector {
 public:
  explicit OrbDetector(const OrbOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 protected:
  std::vector<int> shares(const cv::Size& image_size, int most) const override;

 private:
  OrbOptions options_;
};

/// "orb": rotated BRIEF, on the pyramid level that fits the keypoint's size.
class OrbDescriptor : public OpenCvDescriptor {
 public:
  explicit OrbDescriptor(const OrbOptions& options = {});
  const OptionSet& options() const override { return options_; }

 private:
  OrbOptions options_;
};

}  // namespace corrsel::core
