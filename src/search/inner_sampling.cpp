#include "search/inner_sampling.h"

#include <algorithm>

#include "geometry/residual.h"
#include "search/local_optimization.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kRun = 100;            // iterations of a run
constexpr std::size_t kMatchesPerStep = 10;  // long runs among more matches than kRun times this
constexpr int kSamples = 30;
constexpr float kSquaredWidth = 2.25F;  // of the squared threshold: 1.5 times the threshold

}  // namespace

void InnerSampling::start(const Model& model, const Verifier& verifier, std::uint64_t seed) {
  model_ = &model;
  verifier_ = &verifier;
  random_ = Random(seed);
  leader_ = {};
  run_ = std::max(kRun, verifier.matches().size() / kMatchesPerStep);
  in_run_ = 0;
}

bool InnerSampling::endsRun() {
  if (++in_run_ < run_) return false;
  in_run_ = 0;
  return leader_.exists();
}

bool InnerSampling::improve(Candidate& best) {
  const NormalizedMatches& m = verifier_->matches();
  errors_.resize(m.size());
  modelErrors(verifier_->residual(), leader_.model, m, 0, m.size(), errors_.data());
  const float limit = kSquaredWidth * verifier_->squaredThreshold();
  agreeing_.clear();
  for (std::uint32_t i = 0; i < m.size(); ++i)
    if (errors_[i] <= limit) agreeing_.push_back(i);
  Candidate reached = leader_;
  leader_ = {};
  // The sample itself agrees.
  if (agreeing_.size() <= static_cast<std::size_t>(model_->traits.sample_size)) return false;
  for (int k = 0; k < kSamples; ++k) tryOne(reached);
  if (reached.cost >= best.cost) return false;
  best = reached;
  return true;
}

/// Draws one sample of the agreeing matches, and keeps what lowers the cost.
void InnerSampling::tryOne(Candidate& reached) {
  const auto size = static_cast<std::size_t>(model_->traits.sample_size);
  std::uint32_t sample[Model::kMaxSample];
  random_.sample(static_cast<std::uint32_t>(agreeing_.size()), size, sample);
  for (std::size_t k = 0; k < size; ++k) sample[k] = agreeing_[sample[k]];
  if (!model_->isValidSample(verifier_->matches(), sample)) return;
  cv::Matx33d models[Model::kMaxModels];
  const int count = model_->solve(verifier_->matches(), sample, models);
  for (int k = 0; k < count; ++k) {
    if (!verifier_->improve(models[k], reached)) continue;
    optimizeLocally(*model_, *verifier_, reached);
    std::copy(sample, sample + size, sample_);
  }
}

}  // namespace corrsel::core
