#pragma once

#include <cstdint>
#include <string>

#include "corrsel/confidence.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// The parts of the search for a model. RANSAC and USAC are two sets of values of these options.
struct ConsensusOptions : ConfidenceOptions {
  enum class Error : std::uint8_t { kTransfer, kSymmetricTransfer, kSmallerTransfer };
  enum class Score : std::uint8_t { kMsac, kInlierCount, kMlesac };
  enum class Sampler : std::uint8_t { kUniform, kProsac, kLocal, kFrames, kPnapsac, kMultigs };

  ModelKind model = ModelKind::kHomography;  ///< kNone: what the matches call for
  /// Error of a homography: left to right only, both ways added up, or the smaller one of both ways. A
  /// fundamental matrix is judged by the Sampson distance.
  Error error = Error::kTransfer;
  double threshold = 10.0;     ///< inlier threshold, px
  int max_iterations = 2000;   ///< hypotheses at most; 0 = depends on the sampler
  double confidence = 0.995;   ///< probability of having drawn an all-inlier sample at which the search stops
  Score score = Score::kMsac;  ///< sum of truncated squared errors, number of inliers, or likelihood
  bool one_to_one = false;     ///< every image point counts at most once in the score of a homography
  /// How samples are drawn; see the table of options.
  Sampler sampler = Sampler::kUniform;
  bool sprt = false;  ///< sequential probability ratio test: wrong models are given up early
  double sprt_inlier_ratio =
      0;                  ///< smallest inlier ratio that the SPRT is designed to find; 0 = the model's own
  bool degensac = false;  ///< fundamental matrix: look for a dominant plane and get off it
  bool local_optimization = false;  ///< refine every new best model, not only the last one
  bool refine = true;               ///< least squares on the inliers of the best model
  int seed = 0;                     ///< of the sampler
  double max_seconds = 0;           ///< time limit, s; 0 = none

  /// A sentence that names what the sampler needs and the matches lack; empty if nothing is missing.
  std::string missingInput(const Correspondences& matches) const;

 protected:
  /// What differs between the selectors.
  struct Texts {
    double lowest_threshold;
    const char* threshold;
    double lowest_iterations;
    const char* iterations;
  };

  void visitModel(OptionVisitor& visitor) const;
  void visitSampler(OptionVisitor& visitor) const;
  void visitSeedAndTime(OptionVisitor& visitor) const;

  /// Visits all fields.
  void visitParts(OptionVisitor& visitor, const Texts& texts) const;
};

}  // namespace corrsel::core
