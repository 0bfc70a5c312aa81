#pragma once

#include "corrsel/options.h"

namespace corrsel::core {

/// Options that every detector has beside its own.
struct DetectorOptions : OptionSet {
  int max_features = 0;  ///< only the strongest are kept; 0 = no limit
  bool spread = false;   ///< keep the strongest of every part of the image
  /// Larger images are reduced to this size first, which bounds time and memory: OpenCV's SIFT needs up to
  /// 240 bytes per pixel. 10^6 px.
  double max_megapixels = 12.0;

 protected:
  /// Describes the options above. A derived visit() calls it first.
  void visitCommon(OptionVisitor& visitor) const;
};

}  // namespace corrsel::core
