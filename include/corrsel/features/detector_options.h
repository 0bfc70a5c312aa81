#pragma once

#include "corrsel/options.h"

namespace corrsel::core {

/// What every detector offers beside its own options.
struct DetectorOptions : OptionSet {
  int max_features = 0;  ///< strongest kept; 0 = no cap
  bool spread = false;   ///< keep the strongest of every part of the image

 protected:
  /// Call first in visit().
  void visitCap(OptionVisitor& visitor);
};

}  // namespace corrsel::core
