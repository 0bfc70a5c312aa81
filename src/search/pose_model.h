#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "corrsel/pose_prior.h"
#include "geometry/rays.h"
#include "search/model.h"

namespace corrsel::core {

/// What all models of calibrated cameras share. The hypothesis is an essential matrix, d'^T E d = 0 for unit
/// rays. Hypotheses are compared by the tangent Sampson error in px; matches have rays
/// (NormalizedMatches::rays).
///
/// refine() finds the pose of E that satisfies the prior, and minimises the Geman-McClure loss
/// (geometry/pose_fit.h) in the directions that the prior leaves free, over up to 400 of the matches that
/// agree and lie in front of both cameras. It keeps memory for that, so that every thread has a model of its
/// own.
class PoseModel : public Model {
 public:
  bool isValidSample(const NormalizedMatches& matches, const std::uint32_t* sample) const override;
  bool refine(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& model) const override;
  cv::Matx33d toPixels(const NormalizedMatches& matches, const cv::Matx33d& model) const override;
  double chanceWithinOnePixel(double width, double height) const override;
  Significance significance(SignificanceTest& test, const cv::Matx33d& pixels,
                            std::uint64_t hypotheses) const override;

 protected:
  using Model::Model;

  /// The traits that all these models share; those of sampling are to be set.
  static ModelTraits commonTraits();
  /// The hypothesis of a pose: its essential matrix with Frobenius norm 1.
  static cv::Matx33d hypothesisOf(const Pose& pose);

  /// Sets what refine() keeps to.
  void setPrior(const PosePrior& prior) { prior_ = prior; }

  std::optional<PosePrior> prior_;

 private:
  struct Memory {
    std::vector<float> errors;
    RayMatches agreeing, in_front;
    std::vector<std::uint32_t> rows;
  };
  mutable Memory memory_;
};

}  // namespace corrsel::core
