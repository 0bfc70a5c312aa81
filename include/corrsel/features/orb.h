#pragma once

#include "corrsel/features/opencv_extractor.h"
#include "corrsel/options.h"

namespace corrsel::core {

/// ORB (Rublee et al., ICCV 2011) as in OpenCV's features2d.
struct OrbOptions : OptionSet {
  int max_features = 5000;    ///< strongest kept
  double scale_factor = 1.2;  ///< between pyramid levels
  int levels = 8;             ///< of the pyramid
  int fast_threshold = 20;    ///< smallest corner contrast, grey levels
  int patch_size = 31;        ///< of the descriptor, px; features closer than this to the border are lost

  void visit(OptionVisitor& visitor) override;
};

/// "orb+orb".
class OrbExtractor : public OpenCvExtractor {
 public:
  explicit OrbExtractor(const OrbOptions& options = {});
  const OptionSet& options() const override { return options_; }

 private:
  OrbOptions options_;
};

}  // namespace corrsel::core
