#include "features/parts/image_options.h"

namespace corrsel::core {

void ImageOptions::visit(OptionVisitor& visitor) const {
  visitor.choice("equalize",
                 {{Equalize::kNone, "none", "Features are searched in the image as it is"},
                  {Equalize::kClahe, "clahe", "Contrast-limited adaptive histogram equalization"}},
                 "How the contrast of the image is raised before features are searched",
                 &ImageOptions::equalize);
  visitor.number({"clahe_clip", 0, 1000, "-",
                  "CLAHE: largest count of a grey level, as a multiple of the mean count; it limits the "
                  "contrast and with it the noise; 0 = no limit"},
                 &ImageOptions::clahe_clip);
  visitor.integer(
      {"clahe_tiles", 1, 100, "-", "CLAHE: tiles in each direction, each with a histogram of its own"},
      &ImageOptions::clahe_tiles);
}

}  // namespace corrsel::core
