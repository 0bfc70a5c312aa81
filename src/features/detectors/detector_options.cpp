#include "features/detectors/detector_options.h"

namespace corrsel::core {

void DetectorOptions::visitCommon(OptionVisitor& visitor) const {
  visitor.integer({"max_features", 0, 100000, "-", "Strongest features kept; 0 = no cap"},
                  &DetectorOptions::max_features);
  visitor.flag("spread", "With max_features: keep the strongest of every part of the image",
               &DetectorOptions::spread);
  visitor.number({"max_megapixels", 0.01, 1000, "10^6 px", "Larger images are reduced to this size first"},
                 &DetectorOptions::max_megapixels);
}

}  // namespace corrsel::core
