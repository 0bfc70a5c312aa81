#pragma once

#include "features/parts/opencv_features.h"

namespace corrsel::core {

/// BRISK (Leutenegger, Chli and Siegwart, ICCV 2011) as in OpenCV's features2d.
struct BriskOptions : DetectorOptions {
  int threshold = 30;          ///< smallest corner contrast, grey levels
  int octaves = 3;             ///< of the pyramid
  double pattern_scale = 1.0;  ///< of the sampling pattern

  void visit(OptionVisitor& visitor) const override;
};

/// "brisk".
class BriskDetector : public OpenCvDetector {
 public:
  explicit BriskDetector(const BriskOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 private:
  BriskOptions options_;
};

/// "brisk".
class BriskDescriptor : public OpenCvDescriptor {
 public:
  explicit BriskDescriptor(const BriskOptions& options = {});
  const OptionSet& options() const override { return options_; }

 private:
  BriskOptions options_;
};

}  // namespace corrsel::core
