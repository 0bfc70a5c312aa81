#pragma once

#include "search/model.h"

namespace corrsel::core {

/// A homography from four matches.
///
/// With kSmallerTransfer, the smaller of both transfer errors selects the matches, but hypotheses are
/// compared by the symmetric error: a bad hypothesis that enlarges a spot to the whole image makes one of the
/// two errors small for every match near the spot, and would win. Both errors equal to the threshold make a
/// symmetric error of sqrt(2) thresholds, at which the model is fitted at last. The search itself allows for
/// the noise of minimal samples with two thresholds.
class HomographyModel final : public Model {
 public:
  /// @param residual  kTransfer, kSymmetricTransfer or kSmallerTransfer
  explicit HomographyModel(Residual residual = Residual::kSmallerTransfer);

  bool isValidSample(const NormalizedMatches& matches, const std::uint32_t* sample) const override;
  int solve(const NormalizedMatches& matches, const std::uint32_t* sample,
            cv::Matx33d* models) const override;
  bool refine(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& model) const override;
  cv::Matx33d toPixels(const NormalizedMatches& matches, const cv::Matx33d& model) const override;
  double chanceWithinOnePixel(double width, double height) const override;
  Significance significance(SignificanceTest& test, const cv::Matx33d& pixels,
                            std::uint64_t hypotheses) const override;
};

}  // namespace corrsel::core
