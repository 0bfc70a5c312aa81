#include "corrsel/search/options.h"

namespace corrsel::core {

std::string missingCameras(const Correspondences& matches) {
  if (matches.left_camera && matches.right_camera) return "";
  return std::string("the ") + (matches.left_camera ? "right" : "left") +
         " camera is unknown; give the calibration of both cameras, or choose a selector without cameras";
}

std::string SearchOptions::missingFor(const Correspondences& matches, ModelKind model) const {
  if (model == ModelKind::kEssential) {
    const std::string missing = missingCameras(matches);
    if (!missing.empty()) return missing;
  }
  if (sampler != Sampler::kFrames || matches.empty()) return "";
  if (model != ModelKind::kHomography)
    return "sampler = frames finds homographies only; choose another sampler for another model";
  if (!matches.left_frame.empty() && !matches.right_frame.empty()) return "";
  return "sampler = frames needs the local affine frames of the features; use features that have them, or "
         "choose another sampler";
}

void SearchOptions::visitSampler(OptionVisitor& visitor) const {
  visitor.choice(
      "sampler",
      {{Sampler::kUniform, "uniform", "All matches alike"},
       {Sampler::kProsac, "prosac", "Best descriptor ratios first"},
       {Sampler::kLocal, "local", "A random match and others near it"},
       {Sampler::kFrames, "frames", "Homographies from the local affine frames of single matches"}},
      "How samples are drawn; with frames, single matches take the place of samples",
      &SearchOptions::sampler);
}

void SearchOptions::visitSeedAndTime(OptionVisitor& visitor) const {
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the sampler"}, &SearchOptions::seed);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &SearchOptions::max_seconds);
}

void ConsensusOptions::visitParts(OptionVisitor& visitor, const Texts& texts) const {
  visitCalibratedModel(visitor, &ConsensusOptions::model);
  visitor.choice("error",
                 {{Error::kTransfer, "transfer", "Left to right only"},
                  {Error::kSymmetricTransfer, "symmetric_transfer", "Both ways, squares added up"},
                  {Error::kSmallerTransfer, "smaller_transfer", "The smaller one of both ways"}},
                 "Error of a homography", &ConsensusOptions::error);
  visitor.number({"threshold", texts.min_threshold, 1000, "px", texts.threshold},
                 &ConsensusOptions::threshold);
  visitor.integer({"max_iterations", texts.min_iterations, 10000000, "-", texts.iterations},
                  &ConsensusOptions::max_iterations);
  visitor.number(
      {"confidence", 0, 1, "-", "Probability of an all-inlier sample at which the search stops; 1 = never"},
      &ConsensusOptions::confidence);
  visitor.choice("score",
                 {{Score::kMsac, "msac", "Sum of truncated squared errors"},
                  {Score::kInlierCount, "inlier_count", "Number of inliers"}},
                 "How models are compared", &ConsensusOptions::score);
  visitor.flag("one_to_one", "Every image point counts at most once in the score of a homography",
               &ConsensusOptions::one_to_one);
  visitSampler(visitor);
  visitor.flag("sprt", "Give up bad hypotheses early, by a sequential probability ratio test",
               &ConsensusOptions::sprt);
  visitor.number({"sprt_inlier_ratio", 0, 0.9, "-",
                  "Smallest inlier ratio that the SPRT must not miss; 0 = what max_iterations can find"},
                 &ConsensusOptions::sprt_inlier_ratio);
  visitor.flag("degensac", "Fundamental matrix: look for a dominant plane and get off it",
               &ConsensusOptions::degensac);
  visitor.flag("local_optimization",
               "Refine every new best model, not only the last one, and draw inner samples in long searches",
               &ConsensusOptions::local_optimization);
  visitor.flag("refine", "Least squares on the inliers of the best model", &ConsensusOptions::refine);
  visitSeedAndTime(visitor);
  visitConfidence(visitor);
}

}  // namespace corrsel::core
