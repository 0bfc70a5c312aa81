#include "search/fundamental_model.h"

#include <cmath>

#include "geometry/fundamental.h"
#include "search/degensac.h"

namespace corrsel::core {
namespace {

ModelTraits fundamentalTraits() {
  ModelTraits traits;
  traits.kind = ModelKind::kFundamental;
  traits.sample_size = 7;
  traits.iterations = 40000;
  traits.maps_points = false;
  traits.residual = traits.mask_residual = Residual::kSampson;
  traits.search_width = traits.final_width = 1;
  traits.sprt = {0, 0.05, 2500, 2.38};
  traits.tests_impure_samples = true;
  // The best matches of a scene with several motions may all lie on one, or in one corner, which determines
  // the epipolar geometry poorly. The prefix that ends the search must therefore hold half of all matches,
  // and PROSAC is followed by samples from all of them.
  traits.prosac = {200000, 1};
  traits.min_prefix = 0.5;
  return traits;
}

}  // namespace

FundamentalModel::FundamentalModel() : Model(fundamentalTraits()) {}

bool FundamentalModel::isValidSample(const NormalizedMatches& matches, const std::uint32_t* sample) const {
  return isValidFundamentalSample(matches, sample);
}

int FundamentalModel::solve(const NormalizedMatches& matches, const std::uint32_t* sample,
                            cv::Matx33d* models) const {
  return fundamentalFromSeven(matches, sample, models);
}

bool FundamentalModel::refine(const NormalizedMatches& matches, float squared_threshold,
                              cv::Matx33d& model) const {
  return refineFundamental(matches, squared_threshold, model);
}

bool FundamentalModel::escapeDegeneracy(const Verifier& verifier, const std::uint32_t* sample,
                                        DegeneracyMemory& memory, Candidate& best) const {
  return escapeDominantPlane(verifier, sample, memory, best);
}

cv::Matx33d FundamentalModel::toPixels(const NormalizedMatches& matches, const cv::Matx33d& model) const {
  return matches.fundamentalToPixels(model);
}

double FundamentalModel::chanceWithinOnePixel(double width, double height) const {
  return 2 * std::sqrt(width * width + height * height) / (width * height);
}

Significance FundamentalModel::significance(SignificanceTest& test, const cv::Matx33d& pixels,
                                            std::uint64_t hypotheses) const {
  return test.fundamental(pixels, hypotheses);
}

}  // namespace corrsel::core
