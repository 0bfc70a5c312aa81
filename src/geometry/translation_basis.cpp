#include <cmath>
#include <opencv2/core.hpp>

#include "corrsel/pose_result.h"

namespace corrsel::core {

void translationBasis(const cv::Vec3d& t, cv::Vec3d& b1, cv::Vec3d& b2) {
  int axis = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(t[k]) < std::abs(t[axis])) axis = k;
  }
  cv::Vec3d e;
  e[axis] = 1;
  b1 = cv::normalize(t.cross(e));
  b2 = t.cross(b1);
}

}  // namespace corrsel::core
