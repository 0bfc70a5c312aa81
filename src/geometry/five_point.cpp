#include "geometry/five_point.h"

#include "kernels/kernels.h"

namespace corrsel::core {

void essentialsFromFive(const FivePointSample* samples, int count,
                        cv::Matx33d (*solutions)[kFivePointSolutions], int* counts) {
  static_assert(sizeof(cv::Matx33d) == 9 * sizeof(double), "the kernel writes arrays of nine numbers");
  FivePointRays rays;
  for (int lane = 0; lane < kFivePointBatch; ++lane) {
    // Lanes without a sample repeat the first one.
    const FivePointSample& sample = samples[lane < count ? lane : 0];
    for (int match = 0; match < 5; ++match) {
      for (int axis = 0; axis < 3; ++axis) {
        rays.left[match][axis][lane] = sample.left[match][axis];
        rays.right[match][axis][lane] = sample.right[match][axis];
      }
    }
  }
  kernels().five_point.solve(rays, count, reinterpret_cast<double(*)[kFivePointSolutions][9]>(solutions),
                             counts);
}

}  // namespace corrsel::core
