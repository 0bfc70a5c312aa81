#pragma once

#include <cstdint>
#include <string>

#include "corrsel/confidence.h"
#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// A sentence that names the camera that the matches lack; empty if both are there.
std::string missingCameras(const Correspondences& matches);

/// Options that all searches for models have.
struct SearchOptions : ConfidenceOptions {
  enum class Sampler : std::uint8_t { kUniform, kProsac, kLocal, kFrames };

  /// How samples are drawn; see the table of options.
  Sampler sampler = Sampler::kProsac;
  int max_iterations = 0;  ///< hypotheses at most; 0 = depends on the sampler
  int seed = 0;            ///< of the sampler
  double max_seconds = 0;  ///< time limit, s; 0 = none

 protected:
  void visitSampler(OptionVisitor& visitor) const;
  void visitSeedAndTime(OptionVisitor& visitor) const;

  /// A sentence that names what the sampler or the model needs and the matches lack; empty if nothing is
  /// missing.
  std::string missingFor(const Correspondences& matches, ModelKind model) const;
};

/// The options of RANSAC and USAC, which are two sets of values of them.
struct ConsensusOptions : SearchOptions {
  enum class Error : std::uint8_t { kTransfer, kSymmetricTransfer, kSmallerTransfer };
  enum class Score : std::uint8_t { kMsac, kInlierCount };

  ModelKind model = ModelKind::kHomography;  ///< kHomography, kFundamental or kEssential
  /// Error of a homography: left to right only, both ways added up, or the smaller one of both ways. A
  /// fundamental matrix is scored by the Sampson distance, an essential matrix by the tangent one.
  Error error = Error::kTransfer;
  double threshold = 10.0;     ///< inlier threshold, px
  double confidence = 0.995;   ///< probability of having drawn an all-inlier sample at which the search stops
  Score score = Score::kMsac;  ///< sum of truncated squared errors, or number of inliers
  bool one_to_one = false;     ///< every image point counts at most once in the score of a homography
  bool sprt = false;           ///< sequential probability ratio test: bad hypotheses are given up early
  double sprt_inlier_ratio =
      0;                  ///< smallest inlier ratio that the SPRT is designed to find; 0 = the model's own
  bool degensac = false;  ///< fundamental matrix: look for a dominant plane and get off it
  bool local_optimization = false;  ///< refine every new best model, not only the last one
  bool refine = true;               ///< least squares on the inliers of the best model

  std::string missingInput(const Correspondences& matches) const { return missingFor(matches, model); }

 protected:
  /// What differs between the selectors.
  struct Texts {
    double min_threshold;
    const char* threshold;
    double min_iterations;
    const char* iterations;
  };

  /// Visits all fields.
  void visitParts(OptionVisitor& visitor, const Texts& texts) const;
};

/// Visits the field of an option set that holds the kind of model: a homography or a fundamental matrix.
template <class S>
void visitModel(OptionVisitor& visitor, ModelKind S::*member) {
  visitor.choice("model",
                 {{ModelKind::kHomography, "homography", "Planes, or cameras that only turn"},
                  {ModelKind::kFundamental, "fundamental", "Epipolar geometry of rigid scenes"}},
                 "Model to fit", member);
}

/// The same with the essential matrix, for selectors that use cameras.
template <class S>
void visitCalibratedModel(OptionVisitor& visitor, ModelKind S::*member) {
  visitor.choice("model",
                 {{ModelKind::kHomography, "homography", "Planes, or cameras that only turn"},
                  {ModelKind::kFundamental, "fundamental", "Epipolar geometry of rigid scenes"},
                  {ModelKind::kEssential, "essential", "The same with calibrated cameras"}},
                 "Model to fit", member);
}

}  // namespace corrsel::core
