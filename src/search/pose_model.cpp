#include "search/pose_model.h"

#include <cmath>

#include "geometry/essential.h"
#include "geometry/known_motion.h"
#include "geometry/pose_fit.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMaxRefined = 400;  // matches
constexpr double kWidth = 2.5;            // of the threshold, within which matches take part in the fit
constexpr int kSteps = 8;

}  // namespace

ModelTraits PoseModel::commonTraits() {
  ModelTraits traits = {};
  traits.kind = ModelKind::kEssential;
  traits.iterations = 20000;
  traits.maps_points = false;
  traits.uses_rays = traits.refines_fully = true;
  traits.residual = traits.mask_residual = Residual::kTangentSampson;
  traits.search_width = traits.final_width = 1;
  traits.tests_impure_samples = true;
  traits.prosac = {200000, 1};
  traits.min_prefix = 1.0 / 16;
  traits.batch = 1;
  return traits;
}

cv::Matx33d PoseModel::hypothesisOf(const Pose& pose) { return essentialOf(pose) * std::sqrt(0.5); }

bool PoseModel::isValidSample(const NormalizedMatches&, const std::uint32_t*) const { return true; }

bool PoseModel::refine(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& model) const {
  const std::size_t n = matches.size();
  auto& [errors, agreeing, in_front, rows] = memory_;
  errors.resize(n);
  modelErrors(Residual::kTangentSampson, model, matches, 0, n, errors.data());
  const auto limit = static_cast<float>(kWidth * kWidth) * squared_threshold;
  rows.clear();
  for (std::uint32_t i = 0; i < n && rows.size() < kMaxRefined; ++i)
    if (errors[i] <= limit) rows.push_back(i);
  matches.rays.widen(rows, agreeing);
  const double threshold = std::sqrt(squared_threshold);
  Pose pose;
  if (!choosePose(model, agreeing, threshold, pose, prior_)) return false;
  rows.clear();
  for (std::size_t i = 0; i < agreeing.size(); ++i)
    if (isInFront(pose, agreeing, i, threshold)) rows.push_back(static_cast<std::uint32_t>(i));
  if (rows.size() <= static_cast<std::size_t>(traits.sample_size)) return false;
  gatherRays(agreeing, rows, in_front);
  if (std::isnan(fitPose(in_front, threshold, kSteps, pose, freedomOf(prior_)))) return false;
  model = hypothesisOf(pose);
  return true;
}

cv::Matx33d PoseModel::toPixels(const NormalizedMatches&, const cv::Matx33d& model) const { return model; }

double PoseModel::chanceWithinOnePixel(double width, double height) const {
  return 2 * std::sqrt(width * width + height * height) / (width * height);
}

Significance PoseModel::significance(SignificanceTest& test, const cv::Matx33d& pixels,
                                     std::uint64_t hypotheses) const {
  return test.essential(pixels, hypotheses);
}

}  // namespace corrsel::core
