#pragma once

#include "corrsel/options.h"

namespace corrsel::core {

/// What every detector offers beside its own options.
struct DetectorOptions : OptionSet {
  int max_features = 0;  ///< strongest kept; 0 = no cap
  bool spread = false;   ///< keep the strongest of every part of the image
  /// Larger images are reduced to this size first, which bounds time and memory: SIFT needs up to 240 bytes
  /// per pixel. 10^6 px.
  double max_megapixels = 12.0;

 protected:
  /// Call first in visit().
  void visitCap(OptionVisitor& visitor) const;
};

}  // namespace corrsel::core
