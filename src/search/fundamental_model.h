#pragma once

#include "search/model.h"

namespace corrsel::core {

/// A fundamental matrix from seven matches, by the Sampson distance. Samples that lie mostly on one plane are
/// dealt with by DEGENSAC (search/degensac.h).
class FundamentalModel final : public Model {
 public:
  FundamentalModel();

  bool isValidSample(const NormalizedMatches& matches, const std::uint32_t* sample) const override;
  int solve(const NormalizedMatches& matches, const std::uint32_t* sample,
            cv::Matx33d* models) const override;
  bool refine(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& model) const override;
  bool escapeDegeneracy(const Verifier& verifier, const std::uint32_t* sample, DegeneracyMemory& memory,
                        Candidate& best) const override;
  cv::Matx33d toPixels(const NormalizedMatches& matches, const cv::Matx33d& model) const override;
  double chanceWithinOnePixel(double width, double height) const override;
  Significance significance(SignificanceTest& test, const cv::Matx33d& pixels,
                            std::uint64_t hypotheses) const override;
};

}  // namespace corrsel::core
