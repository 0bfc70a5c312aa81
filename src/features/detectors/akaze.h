#pragma once

#include "features/parts/opencv_features.h"

namespace corrsel::core {

/// AKAZE with its M-LDB descriptor (Alcantarilla, Nuevo and Bartoli, BMVC 2013) as in OpenCV's features2d.
struct AkazeOptions : DetectorOptions {
  double threshold = 0.001;  ///< smallest determinant of the Hessian
  int octaves = 4;           ///< of the non-linear scale space
  int octave_layers = 4;     ///< layers per octave

  void visit(OptionVisitor& visitor) const override;
};

/// "akaze".
class AkazeDetector : public OpenCvDetector {
 public:
  explicit AkazeDetector(const AkazeOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 private:
  AkazeOptions options_;
};

}  // namespace corrsel::core
