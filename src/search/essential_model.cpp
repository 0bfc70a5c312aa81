#include "search/essential_model.h"

#include <algorithm>
#include <cmath>

#include "geometry/essential.h"
#include "geometry/five_point.h"
#include "geometry/pose_fit.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMaxRefined = 400;  // matches
constexpr double kWidth = 2.5;            // of the threshold, within which matches take part in the fit
constexpr int kSteps = 8;

static_assert(Model::kMaxModels >= kFivePointSolutions && kMaxBatch == kFivePointBatch);

ModelTraits essentialTraits() {
  ModelTraits traits;
  traits.kind = ModelKind::kEssential;
  traits.sample_size = 5;
  traits.iterations = 20000;
  traits.maps_points = false;
  traits.uses_rays = traits.refines_fully = true;
  traits.batch = kFivePointBatch;
  traits.residual = traits.mask_residual = Residual::kTangentSampson;
  traits.search_width = traits.final_width = 1;
  traits.sprt = {0, 0.02, 600, 4.5};
  traits.tests_impure_samples = true;
  traits.prosac = {200000, 1};
  traits.min_prefix = 1.0 / 16;
  traits.floor = 8e7;
  return traits;
}

void writeSample(const NormalizedMatches& matches, const std::uint32_t* sample, FivePointSample& out) {
  const std::size_t n = matches.size();
  for (std::size_t k = 0; k < 5; ++k) {
    for (std::size_t c = 0; c < 3; ++c) {
      out.left[k][c] = matches.rays.left[c * n + sample[k]];
      out.right[k][c] = matches.rays.right[c * n + sample[k]];
    }
  }
}

}  // namespace

EssentialModel::EssentialModel() : Model(essentialTraits()) {}

bool EssentialModel::isValidSample(const NormalizedMatches&, const std::uint32_t*) const { return true; }

int EssentialModel::solve(const NormalizedMatches& matches, const std::uint32_t* sample,
                          cv::Matx33d* models) const {
  Hypotheses one;
  std::copy(sample, sample + traits.sample_size, one.sample);
  solveBatch(matches, &one, 1);
  std::copy(one.models, one.models + one.count, models);
  return one.count;
}

void EssentialModel::solveBatch(const NormalizedMatches& matches, Hypotheses* batch, int count) const {
  FivePointSample samples[kFivePointBatch] = {};
  cv::Matx33d solutions[kFivePointBatch][kFivePointSolutions];
  int counts[kFivePointBatch];
  for (int b = 0; b < count; ++b) writeSample(matches, batch[b].sample, samples[b]);
  essentialsFromFive(samples, count, solutions, counts);
  for (int b = 0; b < count; ++b) {
    batch[b].count = counts[b];
    std::copy(solutions[b], solutions[b] + counts[b], batch[b].models);
  }
}

bool EssentialModel::refine(const NormalizedMatches& matches, float squared_threshold,
                            cv::Matx33d& model) const {
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
  if (!choosePose(model, agreeing, threshold, pose)) return false;
  rows.clear();
  for (std::size_t i = 0; i < agreeing.size(); ++i)
    if (isInFront(pose, agreeing, i, threshold)) rows.push_back(static_cast<std::uint32_t>(i));
  if (rows.size() <= static_cast<std::size_t>(traits.sample_size)) return false;
  gatherRays(agreeing, rows, in_front);
  if (std::isnan(fitPose(in_front, threshold, kSteps, pose))) return false;
  model = essentialOf(pose) * std::sqrt(0.5);  // Frobenius norm 1
  return true;
}

cv::Matx33d EssentialModel::toPixels(const NormalizedMatches&, const cv::Matx33d& model) const {
  return model;
}

double EssentialModel::chanceWithinOnePixel(double width, double height) const {
  return 2 * std::sqrt(width * width + height * height) / (width * height);
}

Significance EssentialModel::significance(SignificanceTest& test, const cv::Matx33d& pixels,
                                          std::uint64_t hypotheses) const {
  return test.essential(pixels, hypotheses);
}

}  // namespace corrsel::core
