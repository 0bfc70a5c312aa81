#pragma once

#include "features/detectors/cv_sift.h"

namespace corrsel::core {

struct SiftOptions : DetectorOptions {
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers internally
  double edge_threshold = 10.0;      ///< edge-like extrema are dropped; larger keeps more
  double sigma = 1.6;                ///< blur of the first octave, px
  bool root = false;                 ///< RootSIFT; the one option that only the descriptor uses

  void visit(OptionVisitor& visitor) const override;
};

/// "sift": the same as "cv_sift".
class SiftDetector : public CvSiftDetector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit SiftDetector(const SiftOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 private:
  SiftOptions options_;
};

}  // namespace corrsel::core
