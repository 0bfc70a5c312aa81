#include "features/descriptors/orb.h"

#include <algorithm>
#include <cmath>

namespace corrsel::core {

OrbDescriptor::OrbDescriptor(const OrbOptions& options)
    : OpenCvDescriptor("orb", cvOrbCreator(cvOrbOptions(options)), options.patch_size,
                       [options](const cv::Size& size, cv::KeyPoint& keypoint) {
                         const double level =
                             std::log(keypoint.size / kFastDiameter) / std::log(options.scale_factor);
                         keypoint.octave = static_cast<int>(std::clamp(
                             std::round(level), 0.0, usableCvOrbLevels(cvOrbOptions(options), size) - 1.0));
                       }),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
