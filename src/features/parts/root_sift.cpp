#include "features/parts/root_sift.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {

void toRootSift(cv::Mat& descriptors) {
  for (int row = 0; row < descriptors.rows; ++row) {
    auto* const values = descriptors.ptr<float>(row);
    double total = 0;
    for (int k = 0; k < descriptors.cols; ++k) total += values[k];
    if (!(total > 0)) continue;
    for (int k = 0; k < descriptors.cols; ++k) {
      values[k] = static_cast<float>(std::min(255.0, std::round(512 * std::sqrt(values[k] / total))));
    }
  }
}

}  // namespace corrsel::core
