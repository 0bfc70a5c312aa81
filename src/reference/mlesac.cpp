#include "corrsel/reference/mlesac.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "geometry/residual.h"
#include "reference/error_mixture.h"
#include "reference/search_options.h"
#include "search/second_score.h"
#include "search/uniform_proposal.h"

namespace corrsel::core {
namespace {

/// The mixture for the threshold of a verifier.
ErrorMixture mixtureOf(const Model& model, const Verifier& verifier) {
  constexpr double kBoundOfDistance[] = {1.96, 2.45};  // standard deviations, in one and two dimensions
  const bool points = model.traits.maps_points;
  const auto [width, height] = rightExtent(verifier.matches());
  const double sigma = std::sqrt(double{verifier.squaredThreshold()}) / kBoundOfDistance[points ? 1 : 0];
  const double range = points ? width * height : std::hypot(width, height);
  return {sigma, std::max(range, sigma * sigma), points ? 2 : 1};
}

class Likelihood final : public SecondScore {
 public:
  void start(const Model& model, const Verifier& verifier) override {
    verifier_ = &verifier;
    mixture_ = mixtureOf(model, verifier);
    lowest_cost_ = std::numeric_limits<std::int64_t>::max();
    lowest_ = std::numeric_limits<double>::infinity();
  }

  std::int64_t limit(const Candidate& best) const override {
    if (!best.exists()) return best.cost;
    const auto none = static_cast<std::int64_t>(verifier_->matches().size()) * ScoreRule::kOutlierCost;
    return std::min(lowest_cost_ + lowest_cost_ / 2, none - (none - lowest_cost_) / 3 * 2);
  }

  bool isBest(const cv::Matx33d& hypothesis) override {
    const double cost = costOf(hypothesis);
    if (cost >= lowest_) return false;
    lowest_ = cost;
    return true;
  }

  void adopt(const Candidate& best, bool optimized) override {
    if (optimized) lowest_ = std::min(lowest_, costOf(best.model));
    lowest_cost_ = std::min(lowest_cost_, best.cost);
  }

 private:
  double costOf(const cv::Matx33d& model) {
    const NormalizedMatches& matches = verifier_->matches();
    errors_.resize(matches.size());
    modelErrors(verifier_->residual(), model, matches, 0, matches.size(), errors_.data());
    return fitMixture(errors_.data(), errors_.size(), mixture_, densities_).cost;
  }

  const Verifier* verifier_ = nullptr;
  ErrorMixture mixture_{};
  std::int64_t lowest_cost_ = 0;  // by MSAC, of the best models
  double lowest_ = 0;             // negated logarithm of the likelihood
  std::vector<float> errors_;
  std::vector<double> densities_;
};

}  // namespace

void MlesacSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  constexpr double kThreshold = 10;  // px, that of ransac
  constexpr int kIterations = 2000;  // those of ransac
  SearchParameters parameters;
  parameters.threshold = options_.threshold > 0 ? options_.threshold : kThreshold;
  parameters.max_iterations = options_.max_iterations > 0 ? options_.max_iterations : kIterations;
  parameters.confidence = 0.995;
  parameters.one_to_one = parameters.sprt = parameters.escape_degeneracy = false;
  parameters.local_optimization = false;
  parameters.seed = static_cast<std::uint64_t>(options_.seed);
  const SearchParts parts = {modelOf(options_.model, ConsensusOptions::Error::kTransfer),
                             workspace.part<UniformProposal>(), &workspace.part<Likelihood>()};
  selectByConsensus(matches, parts, parameters, options_.max_seconds, workspace, result);
}

}  // namespace corrsel::core
