#include "ros/bags/bag_topics.h"

#include <stdexcept>

#include "base/text.h"

namespace corrsel {

void BagTopics::check() const {
  if (images != "auto" && images != "raw" && images != "rectified") {
    throw std::invalid_argument("images = '" + images + "' is none of raw, rectified, auto" +
                                core::didYouMean(images, {"raw", "rectified", "auto"}));
  }
  if (!(max_stamp_difference >= 0 && max_stamp_difference <= kMaxStampDifference)) {
    throw std::invalid_argument("max_stamp_difference = " + core::formatNumber(max_stamp_difference) +
                                " is outside [0, " + core::formatNumber(kMaxStampDifference) + "] s");
  }
}

}  // namespace corrsel
