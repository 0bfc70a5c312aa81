#include "search/homography_model.h"

#include "geometry/homography.h"

namespace corrsel::core {
namespace {

ModelTraits traitsOf(Residual residual) {
  const bool smaller = residual == Residual::kSmallerTransfer;
  ModelTraits traits;
  traits.kind = ModelKind::kHomography;
  traits.sample_size = 4;
  traits.iterations = 60000;
  traits.maps_points = true;
  traits.residual = smaller ? Residual::kSymmetricTransfer : residual;
  traits.search_width = smaller ? 2.0 : 1.0;
  traits.mask_residual = residual;
  traits.final_width = smaller ? 1.4142135623730951 : 1.0;
  // Drawing until a sample passes the check and solving it takes about as long as verifying 2000 matches.
  traits.sprt = {0, 0.0008, 2000, 1};
  // Four matches of which one is wrong rarely agree with more than themselves.
  traits.tests_impure_samples = false;
  // Four matches among a few good ones are enough to find a plane, so samples come from short prefixes too.
  traits.prosac = {2000, 8};
  // The twenty best matches may lie in one corner (VGG, trees 1-2), where many bad homographies fit within a
  // wide threshold. The prefix that ends the search must therefore hold one match in twenty.
  traits.min_prefix = 0.05;
  return traits;
}

}  // namespace

HomographyModel::HomographyModel(Residual residual) : Model(traitsOf(residual)) {}

bool HomographyModel::isValidSample(const NormalizedMatches& matches, const std::uint32_t* sample) const {
  return isValidHomographySample(matches, sample);
}

int HomographyModel::solve(const NormalizedMatches& matches, const std::uint32_t* sample,
                           cv::Matx33d* models) const {
  return homographyFromFour(matches, sample, models[0]) ? 1 : 0;
}

bool HomographyModel::refine(const NormalizedMatches& matches, float squared_threshold,
                             cv::Matx33d& model) const {
  return refineHomography(matches, traits.residual, squared_threshold, model);
}

cv::Matx33d HomographyModel::toPixels(const NormalizedMatches& matches, const cv::Matx33d& model) const {
  return matches.homographyToPixels(model);
}

double HomographyModel::chanceWithinOnePixel(double width, double height) const {
  return 3.141592653589793 / (width * height);
}

Significance HomographyModel::significance(SignificanceTest& test, const cv::Matx33d& pixels,
                                           std::uint64_t hypotheses) const {
  return test.homography(pixels, hypotheses);
}

}  // namespace corrsel::core
