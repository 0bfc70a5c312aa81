#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>

#include "corrsel/selection.h"
#include "geometry/normalization.h"
#include "kernels/kernels.h"
#include "search/sampler.h"
#include "search/sprt.h"

namespace corrsel::core {

/// Describes a kind of model to the search.
struct TwoViewProblem {
  static constexpr int kLargestSample = 7, kMostModels = 3;

  ModelKind kind;
  Residual residual;       ///< by which the models of a search are compared
  double search_width;     ///< of the threshold: the inliers of a model in the search
  Residual mask_residual;  ///< decides with the threshold itself which matches are selected
  double final_width;      ///< of the threshold: the inliers to which the model found is fitted at last
  int sample_size;
  /// Sample check: returns whether a pair of cameras can have produced these matches.
  bool (*isValidSample)(const NormalizedMatches& matches, const std::uint32_t* sample);
  /// Minimal solver with the model check: writes up to kMostModels models and returns their number.
  int (*solve)(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d* models);
  /// Takes one least-squares step on the inliers; returns false if it cannot.
  bool (*refine)(const NormalizedMatches& matches, Residual residual, float squared_threshold,
                 cv::Matx33d& model);
  cv::Matx33d (NormalizedMatches::*toPixels)(const cv::Matx33d& model) const;
  /// Probability that a match with a random right point in an image of this size (px) lies within 1 px of a
  /// model.
  double (*chanceWithinOne)(double width, double height);
  SprtConstants sprt;  ///< the search chooses epsilon
  ProsacSchedule prosac;
  double least_prefix;  ///< share of the matches that a prefix needs before PROSAC may stop because of it
};

/// With kSmallerTransfer, the smaller of both transfer errors selects the matches, but models are compared by
/// the symmetric error: a wrong model that enlarges a spot to the whole image makes one of the two errors
/// small for every match near the spot, and would win. Both errors equal to the threshold make a symmetric
/// error of sqrt(2) thresholds, at which the model is fitted at last. The search itself allows for the noise
/// of minimal samples with two thresholds.
/// @param residual  kTransfer, kSymmetricTransfer or kSmallerTransfer
TwoViewProblem homographyProblem(Residual residual);

TwoViewProblem fundamentalProblem();

}  // namespace corrsel::core
