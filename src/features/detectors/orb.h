#pragma once

#include "features/detectors/cv_orb.h"

namespace corrsel::core {

struct OrbOptions : DetectorOptions {
  double scale_factor = 1.2;  ///< between pyramid levels
  int levels = 8;             ///< of the pyramid
  int fast_threshold = 20;    ///< smallest corner contrast, grey levels
  int patch_size = 31;        ///< of the descriptor, px; features closer than this to the border are lost

  OrbOptions() { max_features = 5000; }
  void visit(OptionVisitor& visitor) const override;
};

/// The same options of "cv_orb".
CvOrbOptions cvOrbOptions(const OrbOptions& options);

/// "orb": the same as "cv_orb".
class OrbDetector : public CvOrbDetector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit OrbDetector(const OrbOptions& options = {});
  const DetectorOptions& options() const override { return options_; }

 private:
  OrbOptions options_;
};

}  // namespace corrsel::core
