#pragma once

#include <string>

#include "corrsel/options.h"

namespace corrsel::core {

/// Which parts the search for a model is put together from. RANSAC and USAC are two choices of values.
struct ConsensusOptions : OptionSet {
  std::string model = "homography";  ///< "homography" or "fundamental"
  std::string error = "transfer";    ///< of a homography: "transfer" (left to right) or "symmetric_transfer";
                                     ///< a fundamental matrix is judged by the Sampson distance
  double threshold = 10.0;           ///< inlier threshold, px
  int max_iterations = 2000;         ///< hypotheses at most
  double confidence = 0.995;   ///< probability of having drawn an all-inlier sample at which the search stops
  std::string score = "msac";  ///< "msac" (sum of truncated squared errors) or "inlier_count"
  std::string sampler = "uniform";  ///< "uniform", or "prosac": best descriptor ratios first
  bool sprt = false;                ///< sequential probability ratio test: wrong models are given up early
  double sprt_inlier_ratio =
      0;                  ///< smallest inlier ratio that the SPRT is designed to find; 0 = the model's own
  bool degensac = false;  ///< fundamental matrix: look for a dominant plane and get off it
  bool local_optimization = false;  ///< refine every new best model, not only the last one
  bool refine = true;               ///< least squares on the inliers of the best model
  int seed = 0;                     ///< of the sampler
  double max_seconds = 0;           ///< time limit, s; 0 = none

 protected:
  /// Visits all fields; `lowest_threshold` and `threshold_text` differ between the selectors.
  void visitParts(OptionVisitor& visitor, double lowest_threshold, const char* threshold_text);
};

}  // namespace corrsel::core
