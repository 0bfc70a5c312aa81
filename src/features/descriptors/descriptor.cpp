#include "features/descriptors/descriptor.h"

namespace corrsel::core {

void keepFeatures(const std::vector<char>& keep, Features& features) {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    features.keypoints[kept] = features.keypoints[i];
    features.frames[kept] = features.frames[i];
    ++kept;
  }
  features.keypoints.resize(kept);
  features.frames.resize(kept);
}

}  // namespace corrsel::core
