#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "consensus/sprt.h"
#include "corrsel/selection.h"
#include "geometry/normalization.h"
#include "kernels/kernels.h"

namespace corrsel::core {

/// What the search must know about the kind of model it is after.
struct TwoViewProblem {
  static constexpr int kLargestSample = 7, kMostModels = 3;

  ModelKind kind;
  Residual residual;
  int sample_size;
  /// Sample check: whether a camera pair could have produced these matches.
  bool (*isValidSample)(const NormalizedMatches& matches, const std::uint32_t* sample);
  /// Minimal solver with the model check: writes up to kMostModels, returns how many.
  int (*solve)(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d* models);
  /// One least-squares step on the inliers; false where it cannot be made.
  bool (*refine)(const NormalizedMatches& matches, Residual residual, float squared_threshold,
                 cv::Matx33d& model);
  cv::Matx33d (NormalizedMatches::*toPixels)(const cv::Matx33d& model) const;
  SprtConstants sprt;
  double least_prefix;  ///< share of the matches that a prefix must hold for PROSAC to stop by it
};

/// @param residual  kTransfer or kSymmetricTransfer
TwoViewProblem homographyProblem(Residual residual);

TwoViewProblem fundamentalProblem();

}  // namespace corrsel::core
