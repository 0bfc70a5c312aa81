#pragma once

#include <opencv2/core/matx.hpp>

#include "kernels/five_point.h"

namespace corrsel::core {

/// Five matches of one sample: their unit rays, left and right, x y z.
struct FivePointSample {
  double left[5][3];
  double right[5][3];
};

/// Computes all real essential matrices of samples of five matches, d'^T E d = 0, with Frobenius norm 1 and
/// any sign. Bit-identical at every kernel level.
/// Source: Nister, PAMI 2004, in the form of Stewenius, Engels and Nister, ISPRS 2006, without Sturm chains.
/// @param samples    `count` of them, at most kFivePointBatch
/// @param solutions  receives kFivePointSolutions places per sample
/// @param counts     receives the number of solutions of each sample, 0 for degenerate ones
void essentialsFromFive(const FivePointSample* samples, int count,
                        cv::Matx33d (*solutions)[kFivePointSolutions], int* counts);

}  // namespace corrsel::core
