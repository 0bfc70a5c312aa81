#pragma once

#include <cstdint>
#include <vector>

#include "geometry/rays.h"
#include "search/model.h"

namespace corrsel::core {

/// The essential matrix of calibrated cameras, d'^T E d = 0 for unit rays. Hypotheses are compared by the
/// tangent Sampson error in px; matches have rays (NormalizedMatches::rays).
///
/// Samples of five matches are solved together (geometry/five_point.h). refine() finds the pose of E and
/// minimises the Geman-McClure loss (geometry/pose_fit.h) over up to 400 of the matches that agree and lie in
/// front of both cameras. It keeps memory for that, so that every thread has a model of its own.
class EssentialModel : public Model {
 public:
  EssentialModel();

  bool isValidSample(const NormalizedMatches& matches, const std::uint32_t* sample) const override;
  int solve(const NormalizedMatches& matches, const std::uint32_t* sample,
            cv::Matx33d* models) const override;
  void solveBatch(const NormalizedMatches& matches, Hypotheses* batch, int count) const override;
  bool refine(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& model) const override;
  cv::Matx33d toPixels(const NormalizedMatches& matches, const cv::Matx33d& model) const override;
  double chanceWithinOnePixel(double width, double height) const override;
  Significance significance(SignificanceTest& test, const cv::Matx33d& pixels,
                            std::uint64_t hypotheses) const override;

 private:
  struct Memory {
    std::vector<float> errors;
    RayMatches agreeing, in_front;
    std::vector<std::uint32_t> rows;
  };
  mutable Memory memory_;
};

}  // namespace corrsel::core
