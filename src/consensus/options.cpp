#include "corrsel/consensus/options.h"

namespace corrsel::core {

void ConsensusOptions::visitParts(OptionVisitor& visitor, double lowest_threshold,
                                  const char* threshold_text) {
  visitor.choice("model", {"homography", "fundamental"}, "Model to fit", model);
  visitor.choice("error", {"transfer", "symmetric_transfer"},
                 "Error of a homography: left to right only, or both ways", error);
  visitor.number({"threshold", lowest_threshold, 1000, "px", threshold_text}, threshold);
  visitor.integer({"max_iterations", 1, 10000000, "-", "Hypotheses at most"}, max_iterations);
  visitor.number(
      {"confidence", 0, 1, "-", "Probability of an all-inlier sample at which the search stops; 1 = never"},
      confidence);
  visitor.choice("score", {"msac", "inlier_count"},
                 "Sum of truncated squared errors (msac) or number of inliers", score);
  visitor.choice("sampler", {"uniform", "prosac"},
                 "Uniform samples, or those with the best descriptor ratios first (prosac)", sampler);
  visitor.flag("sprt", "Give up wrong models early, by a sequential probability ratio test", sprt);
  visitor.number(
      {"sprt_inlier_ratio", 0, 0.9, "-",
       "Smallest inlier ratio that the SPRT must not miss; 0 = 0.015 (homography), 0.15 (fundamental)"},
      sprt_inlier_ratio);
  visitor.flag("degensac", "Fundamental matrix: look for a dominant plane and get off it", degensac);
  visitor.flag("local_optimization", "Refine every new best model, not only the last one",
               local_optimization);
  visitor.flag("refine", "Least squares on the inliers of the best model", refine);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the sampler"}, seed);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, max_seconds);
}

}  // namespace corrsel::core
