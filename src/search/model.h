#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/random.h"
#include "corrsel/search/options.h"
#include "corrsel/selection.h"
#include "geometry/normalization.h"
#include "kernels/kernels.h"
#include "search/significance.h"
#include "search/sprt.h"
#include "search/verifier.h"

namespace corrsel::core {

/// How samples are drawn from matches that are ordered by quality.
struct ProsacSchedule {
  double samples = 200000;  ///< T_N: the pool reaches all matches after so many samples
  int prefixes = 1;  ///< later samples come in turn from all matches, the best half, the best quarter...
};

/// The numbers of a kind of model.
struct ModelTraits {
  ModelKind kind;
  int sample_size;            ///< matches of a minimal sample, at most Model::kMaxSample
  int iterations;             ///< hypotheses by default; random matches take all of them, in less than 0.1 s
  bool maps_points;           ///< whether a point has one image, so that every point may count once
  Residual residual;          ///< by which hypotheses are compared
  double search_width;        ///< inlier threshold of the search, in units of the threshold
  Residual mask_residual;     ///< decides with the threshold itself which matches are selected
  double final_width;         ///< like search_width, for the last fit
  SprtConstants sprt;         ///< the search chooses epsilon
  bool tests_impure_samples;  ///< whether the SPRT lets the hypotheses of samples with an outlier or two pass
  ProsacSchedule prosac;
  double min_prefix;       ///< share of the matches that a prefix needs before PROSAC may stop because of it
  bool uses_rays = false;  ///< whether matches need NormalizedMatches::rays
  bool refines_fully = false;  ///< whether refine() converges by itself, so that one call is enough
  double floor = 0;  ///< samples drawn at least, times the squared inliers, from 48 to 5000; 0 = none
  int batch = 1;     ///< samples that are solved together, at most kMaxBatch
};

constexpr int kMaxBatch = 8;

/// Random numbers and memory of Model::escapeDegeneracy() during one search.
struct DegeneracyMemory {
  Random random;
  std::vector<float> errors;
  std::vector<std::uint32_t> rows;
};

struct Hypotheses;

/// A kind of two-view model: all that a search must know of it. One more kind is one more derived class.
///
/// A hypothesis is the 3x3 matrix by which a residual kernel scores the matches, in normalised coordinates. A
/// model with other parameters, such as a pose, recovers them in refine() and returns their matrix.
class Model {
 public:
  static constexpr int kMaxSample = 8, kMaxModels = 10;

  explicit Model(const ModelTraits& values) : traits(values) {}
  virtual ~Model() = default;

  /// Sample check: returns whether a pair of cameras can have produced these matches.
  virtual bool isValidSample(const NormalizedMatches& matches, const std::uint32_t* sample) const = 0;

  /// Minimal solver with the check of its solutions. Writes up to kMaxModels hypotheses.
  /// @return their number
  virtual int solve(const NormalizedMatches& matches, const std::uint32_t* sample,
                    cv::Matx33d* models) const = 0;

  /// The same for several samples, which stand in the batch. @pre count <= kMaxBatch
  virtual void solveBatch(const NormalizedMatches& matches, Hypotheses* batch, int count) const;

  /// One least-squares step on the inliers. @return false if it cannot be taken
  virtual bool refine(const NormalizedMatches& matches, float squared_threshold,
                      cv::Matx33d& model) const = 0;

  /// Replaces `best`, a hypothesis from `sample`, by a better one if the sample is degenerate.
  /// @return whether it was replaced
  virtual bool escapeDegeneracy(const Verifier& verifier, const std::uint32_t* sample,
                                DegeneracyMemory& memory, Candidate& best) const;

  /// The hypothesis in pixels.
  virtual cv::Matx33d toPixels(const NormalizedMatches& matches, const cv::Matx33d& model) const = 0;

  /// Probability that a match with a random right point in an image of this size (px) is within 1 px.
  virtual double chanceWithinOnePixel(double width, double height) const = 0;

  /// The significance of a model in pixels among the matches of the test.
  virtual Significance significance(SignificanceTest& test, const cv::Matx33d& pixels,
                                    std::uint64_t hypotheses) const = 0;

  const ModelTraits traits;
};

/// Hypotheses that were made together, and the sample that they are from.
struct Hypotheses {
  cv::Matx33d models[Model::kMaxModels];
  int count = 0;
  std::uint32_t sample[Model::kMaxSample] = {};
};

/// The model of homographies or of fundamental matrices. They have no state, so there is one of each.
/// @param error  of a homography
const Model& modelOf(ModelKind kind,
                     ConsensusOptions::Error error = ConsensusOptions::Error::kSmallerTransfer);

}  // namespace corrsel::core
