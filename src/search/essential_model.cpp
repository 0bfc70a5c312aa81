#include "search/essential_model.h"

#include <algorithm>

#include "geometry/five_point.h"

namespace corrsel::core {
namespace {

static_assert(Model::kMaxModels >= kFivePointSolutions && kMaxBatch == kFivePointBatch);

ModelTraits essentialTraits(ModelTraits traits) {
  traits.sample_size = 5;
  traits.batch = kFivePointBatch;
  traits.sprt = {0, 0.02, 600, 4.5};
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

EssentialModel::EssentialModel() : PoseModel(essentialTraits(commonTraits())) {}

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

}  // namespace corrsel::core
