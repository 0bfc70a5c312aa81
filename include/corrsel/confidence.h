#pragma once

#include "corrsel/options.h"

namespace corrsel::core {

/// Options of the selectors whose answers have a confidence (Selection::confidence).
struct ConfidenceOptions : OptionSet {
  /// The status is `uncertain` instead of `ok` where the confidence is below this, -log10 units; 0 = never.
  double min_confidence = 0;

 protected:
  void visitConfidence(OptionVisitor& visitor) const;
};

}  // namespace corrsel::core
