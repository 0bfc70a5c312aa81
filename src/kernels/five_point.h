#pragma once

namespace corrsel::core {

/// Samples that are solved together, one per lane.
constexpr int kFivePointBatch = 8;
/// Essential matrices of one sample at most.
constexpr int kFivePointSolutions = 10;

/// Rays of five matches per sample; samples are the last index.
struct FivePointRays {
  double left[5][3][kFivePointBatch];
  double right[5][3][kFivePointBatch];
};

/// The five-point problem.
struct FivePointKernels {
  /// Computes the essential matrices of the first `count` samples, row-major, with Frobenius norm 1. All
  /// lanes of `rays` are read.
  /// @param solutions  receives kFivePointSolutions places per sample
  /// @param counts     receives the number of solutions of each sample
  void (*solve)(const FivePointRays& rays, int count, double (*solutions)[kFivePointSolutions][9],
                int* counts);
};

}  // namespace corrsel::core
