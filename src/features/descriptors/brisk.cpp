#include "features/descriptors/brisk.h"

namespace corrsel::core {

BriskDescriptor::BriskDescriptor(const BriskOptions& options)
    : OpenCvDescriptor("brisk", briskCreator(options), kBriskBorder,
                       [](const cv::Size&, cv::KeyPoint& keypoint) {
                         keypoint.size *= static_cast<float>(kBriskSize / kAgastDiameter);
                       }),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
