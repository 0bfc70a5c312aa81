#include "corrsel/confidence.h"

namespace corrsel::core {

void ConfidenceOptions::visitConfidence(OptionVisitor& visitor) const {
  visitor.number({"min_confidence", 0, 1e6, "-",
                  "Confidence below which the status is uncertain: -log10 of the number of such agreements "
                  "that are expected by chance; 0 = never"},
                 &ConfidenceOptions::min_confidence);
}

}  // namespace corrsel::core
