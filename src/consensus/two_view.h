#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "consensus/sprt.h"
#include "corrsel/selection.h"
#include "geometry/normalization.h"
#include "kernels/kernels.h"

namespace corrsel::core {

/// Describes a kind of model to the search.
struct TwoViewProblem {
  static constexpr int kLargestSample = 7, kMostModels = 3;

  ModelKind kind;
  Residual residual;
  int sample_size;
  /// Sample check: returns whether a pair of cameras can have produced these matches.
  bool (*isValidSample)(const NormalizedMatches& matches, const std::uint32_t* sample);
  /// Minimal solver with the model check: writes up to kMostModels models and returns their number.
  int (*solve)(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d* models);
  /// Takes one least-squares step on the inliers; returns false if it cannot.
  bool (*refine)(const NormalizedMatches& matches, Residual residual, float squared_threshold,
                 cv::Matx33d& model);
  cv::Matx33d (NormalizedMatches::*toPixels)(const cv::Matx33d& model) const;
  SprtConstants sprt;
  double least_prefix;  ///< share of the matches that a prefix needs before PROSAC may stop because of it
};

/// @param residual  kTransfer or kSymmetricTransfer
TwoViewProblem homographyProblem(Residual residual);

TwoViewProblem fundamentalProblem();

}  // namespace corrsel::core
