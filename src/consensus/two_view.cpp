#include "consensus/two_view.h"

#include "geometry/fundamental.h"
#include "geometry/homography.h"

namespace corrsel::core {
namespace {

int solveHomography(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d* models) {
  return homographyFromFour(matches, sample, models[0]) ? 1 : 0;
}

bool refineF(const NormalizedMatches& matches, Residual, float squared_threshold, cv::Matx33d& model) {
  return refineFundamental(matches, squared_threshold, model);
}

}  // namespace

TwoViewProblem homographyProblem(Residual residual) {
  // The search must find models when 5 % of the matches are correct. A model made from a noisy sample agrees
  // with a third of those. Drawing until a sample passes the check and solving it takes about as long as
  // verifying 2000 matches. The twenty best matches may lie in one corner (VGG, trees 1-2), where many wrong
  // homographies fit within a wide threshold. The prefix must therefore hold one match in twenty.
  return {ModelKind::kHomography,
          residual,
          4,
          isValidHomographySample,
          solveHomography,
          refineHomography,
          &NormalizedMatches::homographyToPixels,
          {0.015, 0.0008, 2000, 1},
          0.05};
}

TwoViewProblem fundamentalProblem() {
  // The best matches of a scene with several motions may all lie on one, or in one corner, which determines
  // the epipolar geometry poorly. The prefix must therefore hold half of all matches.
  return {ModelKind::kFundamental,
          Residual::kSampson,
          7,
          isValidFundamentalSample,
          fundamentalFromSeven,
          refineF,
          &NormalizedMatches::fundamentalToPixels,
          {0.15, 0.05, 2500, 2.38},
          0.5};
}

}  // namespace corrsel::core
