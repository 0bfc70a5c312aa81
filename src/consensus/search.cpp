#include "consensus/search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "base/deadline.h"
#include "base/text.h"
#include "base/workspace_scope.h"
#include "consensus/degensac.h"
#include "consensus/local_optimization.h"
#include "consensus/ordering.h"
#include "consensus/sampler.h"
#include "consensus/sprt.h"
#include "consensus/stopping.h"
#include "consensus/two_view.h"
#include "consensus/verifier.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

/// Memory that is kept between calls.
struct SearchMemory {
  Ordering ordering;
  std::vector<std::uint32_t> rows;        // input rows in random order: the order of everything below
  std::vector<std::uint32_t> best_first;  // the same numbers by quality
  NormalizedMatches matches;
  std::vector<float> errors;
  Degensac::Scratch degensac;
  std::vector<double> pixel_errors;
};

TwoViewProblem problemOf(const ConsensusOptions& options) {
  if (options.model == ModelKind::kFundamental) return fundamentalProblem();
  return homographyProblem(options.error == ConsensusOptions::Error::kTransfer
                               ? Residual::kTransfer
                               : Residual::kSymmetricTransfer);
}

class Search {
 public:
  Search(const ConsensusOptions& options, const TwoViewProblem& problem, double threshold, bool by_quality,
         const Deadline& deadline, SearchMemory& work)
      : options_(options),
        problem_(problem),
        deadline_(deadline),
        work_(work),
        verifier_(work.matches, problem.residual, threshold * work.matches.scale,
                  options.score == ConsensusOptions::Score::kMsac),
        sampler_(by_quality ? Sampler(work.best_first, problem.sample_size, seed())
                            : Sampler(work.matches.size(), problem.sample_size, seed())),
        by_quality_(by_quality),
        stopping_(options.confidence, work.matches.size(), problem.sample_size),
        degensac_(seed() + 1, work.degensac) {
    if (options.sprt) {
      sprt_.emplace(sprtConstants(), problem.sample_size / static_cast<double>(work.matches.size()));
      stopping_.setLoss(sprt_->loss(), 0);
    }
  }

  /// @return the best model found
  Candidate run(int& iterations) {
    std::uint32_t sample[TwoViewProblem::kLargestSample];
    cv::Matx33d models[TwoViewProblem::kMostModels];
    for (; iterations < options_.max_iterations && !stopping_.enough(sampler_.drawn()); ++iterations) {
      if (outOfTime() || !drawValidSample(sample)) break;
      const int count = problem_.solve(work_.matches, sample, models);
      for (int k = 0; k < count; ++k) tryModel(models[k], sample);
    }
    if (best_.exists() && options_.refine && !optimized_) optimizeLocally(problem_, verifier_, best_);
    return best_;
  }

  /// Whether the time limit ended the search.
  bool timedOut() const { return timed_out_; }

 private:
  /// Returns whether the time limit has passed. Reads the clock once in kSamplesPerLook samples, which take
  /// well below a millisecond, and after each new best model, which may take longer.
  bool outOfTime() {
    constexpr std::uint64_t kSamplesPerLook = 100;
    if (sampler_.drawn() < next_look_) return false;
    next_look_ = sampler_.drawn() + kSamplesPerLook;
    timed_out_ = deadline_.passed();
    return timed_out_;
  }

  SprtConstants sprtConstants() const {
    SprtConstants constants = problem_.sprt;
    if (options_.sprt_inlier_ratio > 0) {
      constants.delta *= options_.sprt_inlier_ratio / constants.epsilon;
      constants.epsilon = options_.sprt_inlier_ratio;
    }
    return constants;
  }

  std::uint64_t seed() const { return static_cast<std::uint64_t>(options_.seed); }

  bool drawValidSample(std::uint32_t* sample) {
    // As in OpenCV, so many refusals mean that there is no valid sample.
    constexpr int kMostRefusals = 10000;
    // Limits the average number of samples per hypothesis, for data with hardly any valid sample.
    constexpr std::uint64_t kSamplesPerHypothesis = 50;
    const std::uint64_t most =
        kMostRefusals + kSamplesPerHypothesis * static_cast<std::uint64_t>(options_.max_iterations);
    for (int refused = 0; refused < kMostRefusals && sampler_.drawn() < most; ++refused) {
      sampler_.draw(sample);
      if (problem_.isValidSample(work_.matches, sample)) return true;
    }
    return false;
  }

  void tryModel(const cv::Matx33d& model, const std::uint32_t* sample) {
    const ModelScore score =
        sprt_ ? verifier_.test(model, best_.cost, *sprt_) : verifier_.score(model, best_.cost);
    if (score.rejected_by_sprt && sprt_->addRejected(score))
      stopping_.setLoss(sprt_->loss(), sampler_.drawn());
    if (score.rejected) return;
    best_ = {model, score.cost, score.inliers};
    next_look_ = 0;
    optimized_ = false;
    if (options_.degensac && problem_.kind == ModelKind::kFundamental)
      degensac_.escape(verifier_, sample, best_);
    // A model with little more than its own sample is noise and not worth the steps.
    constexpr std::size_t kWorthwhile = 4;
    if (options_.local_optimization &&
        best_.inliers >= kWorthwhile * static_cast<std::size_t>(problem_.sample_size)) {
      optimizeLocally(problem_, verifier_, best_);
      optimized_ = true;
    }
    const double ratio = static_cast<double>(best_.inliers) / static_cast<double>(work_.matches.size());
    if (sprt_ && sprt_->addBest(ratio)) stopping_.setLoss(sprt_->loss(), sampler_.drawn());
    stopping_.setInliers(best_.inliers);
    if (by_quality_) stopByPrefix();
  }

  /// Stopping condition of PROSAC. Considers the prefixes of the best matches from which all samples so far
  /// were drawn, that are long enough for the kind of model, and whose number of inliers is not explained by
  /// chance (inlier probability 5 %, confidence 95 %, normal approximation of the binomial tail). Takes the
  /// prefix with the largest share of inliers.
  void stopByPrefix() {
    constexpr std::size_t kLeastPrefix = 20;
    constexpr double kChance = 0.05, kSquaredQuantile = 2.706;
    const std::size_t n = work_.matches.size(), m = static_cast<std::size_t>(problem_.sample_size);
    work_.errors.resize(n);
    modelErrors(problem_.residual, best_.model, work_.matches, 0, n, work_.errors.data());
    const auto share = static_cast<std::size_t>(problem_.least_prefix * static_cast<double>(n));
    const std::size_t least = std::max<std::size_t>({kLeastPrefix, sampler_.pool(), share});
    std::size_t inliers = 0, best_inliers = 0, best_pool = 1;
    for (std::size_t i = 0; i < n; ++i) {
      inliers += work_.errors[work_.best_first[i]] <= verifier_.squaredThreshold() ? 1 : 0;
      const std::size_t pool = i + 1;
      if (pool < least || inliers * best_pool <= best_inliers * pool) continue;
      const double mean = kChance * static_cast<double>(pool - m);
      const double enough =
          static_cast<double>(m) + mean + std::sqrt(kSquaredQuantile * mean * (1 - kChance));
      if (static_cast<double>(inliers) < enough) continue;
      best_inliers = inliers;
      best_pool = pool;
    }
    if (best_inliers > 0) stopping_.setPrefix(best_inliers, best_pool);
  }

  const ConsensusOptions& options_;
  const TwoViewProblem& problem_;
  const Deadline& deadline_;
  SearchMemory& work_;
  Verifier verifier_;
  Sampler sampler_;
  bool by_quality_;
  StoppingRule stopping_;
  Degensac degensac_;
  std::optional<Sprt> sprt_;
  Candidate best_;
  std::uint64_t next_look_ = 0;  // at the clock, samples
  bool optimized_ = false, timed_out_ = false;
};

/// Appends a remark to the message.
void addRemark(Selection& result, const std::string& text) {
  result.message += (result.message.empty() ? "" : "; ") + text;
}

void report(const Correspondences& matches, const TwoViewProblem& problem, double threshold,
            const Candidate& best, SearchMemory& work, Selection& result) {
  result.model = (work.matches.*problem.toPixels)(best.model);
  result.model_kind = problem.kind;
  const std::size_t n = matches.size();
  work.pixel_errors.resize(n);
  pixelErrors(problem.residual, result.model, matches, work.pixel_errors.data());
  result.score.resize(n);
  std::size_t inliers = 0;
  for (std::size_t i = 0; i < n; ++i) {
    result.score[i] = static_cast<float>(-work.pixel_errors[i]);
    result.mask[i] = work.pixel_errors[i] <= threshold * threshold ? 1 : 0;
    inliers += result.mask[i];
  }
  if (inliers <= static_cast<std::size_t>(problem.sample_size)) {
    std::fill(result.mask.begin(), result.mask.end(), std::uint8_t{0});
    // With more time the search might have found a better model.
    if (result.status != Status::kTimeLimit) {
      result.status = Status::kDegenerate;
      result.message.clear();
    }
    addRemark(result, "only its own sample agrees with the best model, which is therefore unverified");
  }
}

}  // namespace

void searchConsensus(const Correspondences& matches, const ConsensusOptions& options, double threshold,
                     Selection& result) {
  const Deadline deadline(options.max_seconds);
  const TwoViewProblem problem = problemOf(options);
  const std::size_t n = matches.size();
  if (n < static_cast<std::size_t>(problem.sample_size)) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " matches, a " + toString(problem.kind) + " needs " +
                     std::to_string(problem.sample_size);
    return;
  }
  SearchMemory& work = WorkspaceScope::part<SearchMemory>();
  work.ordering.shuffle(matches, static_cast<std::uint64_t>(options.seed), work.rows);
  normalizeMatches(matches, work.rows, work.matches);
  const bool prosac = options.sampler == ConsensusOptions::Sampler::kProsac;
  const bool by_quality = prosac && work.ordering.byQuality(matches, work.rows, work.best_first);
  if (prosac && !by_quality)
    result.message =
        "the matches have no descriptor distances, so samples are drawn uniformly instead of by PROSAC";
  Search search(options, problem, threshold, by_quality, deadline, work);
  const Candidate best = search.run(result.iterations);
  if (search.timedOut()) {
    result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
    addRemark(result, "stopped after " + std::to_string(result.iterations) + " hypotheses" +
                          (best.exists() ? "" : ", none of them good enough") +
                          ", max_seconds = " + formatNumber(options.max_seconds));
  }
  if (best.exists()) {
    report(matches, problem, threshold, best, work, result);
  } else if (search.timedOut()) {
    return;
  } else if (result.iterations < options.max_iterations) {
    result.status = Status::kDegenerate;
    result.message = "no sample is valid: the matches are collinear, equal or differently oriented";
  } else {
    result.status = Status::kNoModel;
    result.message = "no hypothesis could be fitted";
  }
}

}  // namespace corrsel::core
