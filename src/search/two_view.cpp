#include "search/two_view.h"

#include <cmath>

#include "geometry/fundamental.h"
#include "geometry/homography.h"

namespace corrsel::core {
namespace {

int solveHomography(const NormalizedMatches& matches, const std::uint32_t* sample, cv::Matx33d* models) {
  return homographyFromFour(matches, sample, models[0]) ? 1 : 0;
}

double chanceOfPoint(double width, double height) { return 3.141592653589793 / (width * height); }

double chanceOfLine(double width, double height) {
  return 2 * std::sqrt(width * width + height * height) / (width * height);
}

bool refineF(const NormalizedMatches& matches, Residual, float squared_threshold, cv::Matx33d& model) {
  return refineFundamental(matches, squared_threshold, model);
}

}  // namespace

TwoViewProblem homographyProblem(Residual residual) {
  const bool smaller = residual == Residual::kSmallerTransfer;
  // Drawing until a sample passes the check and solving it takes about as long as verifying 2000 matches.
  // Four matches among a few good ones are enough to find a plane, so samples come from short prefixes too.
  // The twenty best matches may lie in one corner (VGG, trees 1-2), where many wrong homographies fit within
  // a wide threshold. The prefix that ends the search must therefore hold one match in twenty.
  return {ModelKind::kHomography,
          smaller ? Residual::kSymmetricTransfer : residual,
          smaller ? 2.0 : 1.0,
          residual,
          smaller ? 1.4142135623730951 : 1.0,
          4,
          isValidHomographySample,
          solveHomography,
          refineHomography,
          &NormalizedMatches::homographyToPixels,
          chanceOfPoint,
          {0, 0.0008, 2000, 1},
          {2000, 8},
          0.05};
}

TwoViewProblem fundamentalProblem() {
  // The best matches of a scene with several motions may all lie on one, or in one corner, which determines
  // the epipolar geometry poorly. The prefix that ends the search must therefore hold half of all matches,
  // and PROSAC is followed by samples from all of them.
  return {ModelKind::kFundamental,
          Residual::kSampson,
          1.0,
          Residual::kSampson,
          1.0,
          7,
          isValidFundamentalSample,
          fundamentalFromSeven,
          refineF,
          &NormalizedMatches::fundamentalToPixels,
          chanceOfLine,
          {0, 0.05, 2500, 2.38},
          {200000, 1},
          0.5};
}

}  // namespace corrsel::core
