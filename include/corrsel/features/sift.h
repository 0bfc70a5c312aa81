#pragma once

#include "corrsel/features/opencv_extractor.h"
#include "corrsel/options.h"

namespace corrsel::core {

/// SIFT (Lowe, IJCV 2004) as in OpenCV's features2d.
struct SiftOptions : OptionSet {
  int max_features = 0;              ///< strongest kept; 0 = no cap
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers inside
  double edge_threshold = 10.0;      ///< edge-like extrema are dropped; larger keeps more
  double sigma = 1.6;                ///< blur of the first octave, px

  void visit(OptionVisitor& visitor) override;
};

/// "sift+sift".
class SiftExtractor : public OpenCvExtractor {
 public:
  explicit SiftExtractor(const SiftOptions& options = {});
  const OptionSet& options() const override { return options_; }

 private:
  SiftOptions options_;
};

}  // namespace corrsel::core
