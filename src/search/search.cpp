#include "search/search.h"

#include <algorithm>
#include <limits>
#include <optional>

#include "base/gather.h"
#include "geometry/residual.h"
#include "search/inner_sampling.h"
#include "search/local_optimization.h"
#include "search/sprt.h"
#include "search/stopping.h"
#include "search/support.h"

namespace corrsel::core {
namespace {

/// Iterations before the first inner samples. Most searches end earlier.
constexpr int kFirstInner = 2000;

/// Memory of a search that is kept between calls.
struct SearchMemory {
  std::vector<float> errors;
  DegeneracyMemory degeneracy;
  DistinctSupport distinct;
  InnerSampling inner;
  std::vector<std::uint8_t> counts;  // whether a match is the best one of its points by quality
  // The matches that take part, where they are not all.
  NormalizedMatches subset;
  std::vector<std::uint32_t> positions, order;
};

class Search {
 public:
  Search(const NormalizedMatches& matches, const SearchParts& parts, const SearchParameters& parameters,
         const std::vector<std::uint32_t>* best_first, const Deadline& deadline, SearchMemory& memory)
      : matches_(matches),
        parts_(parts),
        parameters_(parameters),
        deadline_(deadline),
        memory_(memory),
        model_(parts.model.traits),
        traits_(parts.proposal.traits),
        one_to_one_(parameters.one_to_one && model_.maps_points),
        max_iterations_(maxIterations()),
        verifier_(matches, model_.residual, model_.search_width * parameters.threshold * matches.scale,
                  parameters.msac, one_to_one_ ? &memory.distinct : nullptr),
        stopping_(parameters.confidence, countDistinct(), model_.sample_size) {
    memory_.degeneracy.random = Random(parameters.seed + 1);
    parts_.proposal.start({matches, best_first, parts.model, max_iterations_, parameters.seed, deadline});
    memory_.counts.clear();
    if (one_to_one_ && parts_.proposal.prefixes() != nullptr)
      memory_.distinct.markFirst(*parts_.proposal.prefixes(), memory_.counts);
    if (parts_.second_score != nullptr) parts_.second_score->start(parts_.model, verifier_);
    if (parameters.sprt && !traits_.rough) startSprt(best_first != nullptr);
    memory_.inner.start(parts_.model, verifier_, parameters.seed + 2);
  }

  SearchOutcome run() {
    Proposal& proposal = parts_.proposal;
    Hypotheses hypotheses;
    Candidate& best = outcome_.best;
    if (parts_.first != nullptr) begin(*parts_.first);
    for (; outcome_.iterations < max_iterations_; ++outcome_.iterations) {
      if (proposal.isFinished(best) || isEnough(proposal.drawn())) break;
      if (nothingLeftToFind(proposal.drawn()) || isTimeOver()) break;
      const Proposed proposed = proposal.propose(hypotheses);
      outcome_.no_valid_sample = proposed == Proposed::kNoValidSample;
      outcome_.timed_out = proposed == Proposed::kTimeLimit;
      if (proposed != Proposed::kHypotheses) break;
      for (int k = 0; k < hypotheses.count; ++k) {
        const cv::Matx33d& model = hypotheses.models[k];
        const bool better = traits_.rough          ? isBetterRefined(model)
                            : model_.refines_fully ? isBetterOptimized(model)
                                                   : isBetter(model);
        if (better) adopt(hypotheses.sample);
        proposal.learn(model);
      }
      if (takesInnerSamples() && memory_.inner.endsRun() && memory_.inner.improve(best))
        adopt(memory_.inner.sample());
    }
    if (best.exists() && parameters_.refine && !optimized_) optimizeLocally(parts_.model, verifier_, best);
    return outcome_;
  }

 private:
  /// Refines and adopts a hypothesis that is not from a sample. Those of samples are not compared with it
  /// before their own refinement.
  void begin(const cv::Matx33d& first) {
    if (!verifier_.improve(first, outcome_.best)) return;
    optimizeLocally(parts_.model, verifier_, outcome_.best);
    optimized_ = true;
    adopt(nullptr);
  }

  int maxIterations() const {
    const int by_default = traits_.iterations > 0 ? traits_.iterations : model_.iterations;
    return std::min(parameters_.max_iterations > 0 ? parameters_.max_iterations : by_default,
                    traits_.max_iterations);
  }

  /// Whether the search may stop. Where few matches agree, the stopping rule trusts the best model too early:
  /// the inliers that it lacks are those that a better one would add.
  bool isEnough(std::uint64_t drawn) const {
    constexpr double kMin = 48, kMax = 5000;
    if (!stopping_.enough(drawn)) return false;
    if (!(model_.floor > 0) || parts_.first != nullptr) return true;
    const double inliers = std::max<double>(1, static_cast<double>(outcome_.best.distinct));
    return static_cast<double>(drawn) >= std::clamp(model_.floor / (inliers * inliers), kMin, kMax);
  }

  /// Returns the number of matches that count, and prepares the count if every point counts once.
  std::size_t countDistinct() {
    if (!one_to_one_) return matches_.size();
    // Points that are closer together than the threshold would not differ in another unit either.
    memory_.distinct.group(matches_, std::min(1.0, parameters_.threshold) * matches_.scale);
    return memory_.distinct.distinctMatches();
  }

  void startSprt(bool ordered) {
    SprtConstants constants = model_.sprt;
    // An order by quality finds rarer models, and so do inner samples.
    const bool finds_rarer = ordered || (model_.tests_impure_samples && max_iterations_ > kFirstInner);
    constants.epsilon = parameters_.sprt_inlier_ratio > 0
                            ? parameters_.sprt_inlier_ratio
                            : minTestedRatio(max_iterations_, finds_rarer, model_.sample_size);
    sprt_.emplace(constants, model_.sample_size / static_cast<double>(matches_.size()));
    stopping_.setLoss(sprt_->loss(), 0);
  }

  /// Whether more samples cannot gain anything. Most searches end before this takes the time to find out.
  /// Samples of crowded matches that the check refuses count as hypotheses.
  bool nothingLeftToFind(std::uint64_t drawn) {
    const auto samples = static_cast<double>(drawn);
    if (traits_.crowded) return samples >= max_iterations_;
    if (samples < kMinSignificanceSamples) return false;
    if (!max_samples_)
      max_samples_ = samplesForMinSignificance(matches_, parts_.model, parameters_.confidence);
    return samples >= *max_samples_;
  }

  /// Reads the clock once in kSamplesPerLook samples, which take well below a millisecond, and after each new
  /// best model, which may take longer.
  bool isTimeOver() {
    constexpr std::uint64_t kSamplesPerLook = 100;
    const std::uint64_t drawn = parts_.proposal.drawn();
    if (drawn < next_look_) return false;
    next_look_ = drawn + (traits_.slow ? 1 : kSamplesPerLook);
    outcome_.timed_out = deadline_.passed();
    return outcome_.timed_out;
  }

  bool takesInnerSamples() const {
    return outcome_.iterations >= kFirstInner && parameters_.local_optimization && !traits_.rough &&
           !model_.refines_fully && parts_.second_score == nullptr;
  }

  /// Scores a hypothesis against the best one of its kind, in full or until the SPRT rejects it.
  ModelScore scoreOf(const cv::Matx33d& model, std::int64_t limit) {
    const ModelScore score = sprt_ ? verifier_.test(model, limit, *sprt_) : verifier_.score(model, limit);
    if (score.rejected_by_sprt && sprt_->addRejected(score))
      stopping_.setLoss(sprt_->loss(), parts_.proposal.drawn());
    return score;
  }

  /// Scores a hypothesis and keeps it if it is the best one so far.
  bool isBetter(const cv::Matx33d& model) {
    Candidate& best = outcome_.best;
    SecondScore* const second = parts_.second_score;
    const bool inner = takesInnerSamples();
    const std::int64_t limit = second != nullptr ? second->limit(best)
                               : inner           ? std::max(best.cost, memory_.inner.limit())
                                                 : best.cost;
    const ModelScore score = scoreOf(model, limit);
    if (score.rejected || (second != nullptr && !second->isBest(model))) return false;
    const Candidate scored = {model, score.cost, score.inliers, score.inliers - score.surplus};
    if (inner && score.cost < memory_.inner.limit()) memory_.inner.offer(scored);
    if (second == nullptr && score.cost >= best.cost) return false;
    best = scored;
    optimized_ = false;
    return true;
  }

  /// The same for a model whose refinement is so good that hypotheses are compared before it. Otherwise none
  /// but the first would be refined, and the search would end in the first minimum.
  bool isBetterOptimized(const cv::Matx33d& model) {
    const ModelScore score = scoreOf(model, best_unrefined_);
    if (score.rejected || score.cost >= best_unrefined_) return false;
    best_unrefined_ = score.cost;
    Candidate candidate = {model, score.cost, score.inliers, score.inliers - score.surplus};
    if (parameters_.local_optimization) optimizeLocally(parts_.model, verifier_, candidate);
    if (candidate.cost >= outcome_.best.cost) return false;
    outcome_.best = candidate;
    optimized_ = parameters_.local_optimization;
    return true;
  }

  /// The same for a hypothesis that must be refined first.
  bool isBetterRefined(const cv::Matx33d& model) {
    Candidate candidate;
    if (!verifier_.improve(model, candidate)) return false;
    optimizeLocally(parts_.model, verifier_, candidate);
    if (candidate.cost >= outcome_.best.cost) return false;
    outcome_.best = candidate;
    optimized_ = true;
    return true;
  }

  /// Improves a new best model, and tells the other parts of it.
  void adopt(const std::uint32_t* sample) {
    Candidate& best = outcome_.best;
    next_look_ = 0;
    if (traits_.rough) return;
    if (parameters_.escape_degeneracy)
      parts_.model.escapeDegeneracy(verifier_, sample, memory_.degeneracy, best);
    // A model with little more than its own sample is noise and not worth the steps.
    constexpr std::size_t kWorthwhile = 4;
    if (parameters_.local_optimization && !model_.refines_fully &&
        best.distinct >= kWorthwhile * static_cast<std::size_t>(model_.sample_size)) {
      optimizeLocally(parts_.model, verifier_, best);
      optimized_ = true;
    }
    if (parts_.second_score != nullptr) parts_.second_score->adopt(best, optimized_);
    // A better model has at least as many inliers that count.
    const double ratio = static_cast<double>(best.distinct) / static_cast<double>(matches_.size());
    if (sprt_ && sprt_->addBest(ratio)) stopping_.setLoss(sprt_->loss(), parts_.proposal.drawn());
    stopping_.setInliers(best.distinct);
    if (parts_.proposal.prefixes() != nullptr) stopByPrefix(*parts_.proposal.prefixes());
  }

  void stopByPrefix(const std::vector<std::uint32_t>& order) {
    const std::size_t n = matches_.size();
    memory_.errors.resize(n);
    modelErrors(model_.residual, outcome_.best.model, matches_, 0, n, memory_.errors.data());
    const MatchShare prefix = bestPrefix(order, memory_.errors, verifier_.squaredThreshold(), memory_.counts,
                                         model_, parts_.proposal.pool());
    if (prefix.inliers > 0) stopping_.setPrefix(prefix.inliers, prefix.pool);
  }

  const NormalizedMatches& matches_;
  const SearchParts& parts_;
  const SearchParameters& parameters_;
  const Deadline& deadline_;
  SearchMemory& memory_;
  const ModelTraits& model_;
  const ProposalTraits& traits_;
  bool one_to_one_;
  int max_iterations_;
  Verifier verifier_;
  StoppingRule stopping_;
  std::optional<Sprt> sprt_;
  std::optional<double> max_samples_;
  SearchOutcome outcome_;
  std::int64_t best_unrefined_ = std::numeric_limits<std::int64_t>::max();
  std::uint64_t next_look_ = 0;  // at the clock, samples
  bool optimized_ = false;       // the best model
};

/// Gathers the matches at the given positions, which keep their coordinates.
void gatherMatches(const NormalizedMatches& from, const std::vector<std::uint32_t>& positions,
                   NormalizedMatches& to) {
  to.scale = from.scale;
  to.rounding = from.rounding;
  to.left = from.left;
  to.right = from.right;
  gather(from.left_x, positions, to.left_x);
  gather(from.left_y, positions, to.left_y);
  gather(from.right_x, positions, to.right_x);
  gather(from.right_y, positions, to.right_y);
  if (from.rays.size > 0) to.rays.take(from.rays, positions);
}

}  // namespace

SearchOutcome search(const NormalizedMatches& matches, const SearchParts& parts,
                     const SearchParameters& parameters, const std::vector<std::uint32_t>* best_first,
                     const Deadline& deadline, Workspace& workspace) {
  SearchMemory& memory = workspace.part<SearchMemory>();
  const bool ordered = best_first != nullptr && parts.proposal.traits.uses_quality;
  if (best_first == nullptr || best_first->size() == matches.size()) {
    return Search(matches, parts, parameters, ordered ? best_first : nullptr, deadline, memory).run();
  }
  // Ascending positions keep the random order.
  std::vector<std::uint32_t>& positions = memory.positions;
  positions = *best_first;
  std::sort(positions.begin(), positions.end());
  gatherMatches(matches, positions, memory.subset);
  memory.order.clear();
  for (const std::uint32_t i : *best_first) {
    const auto place = std::lower_bound(positions.begin(), positions.end(), i);
    memory.order.push_back(static_cast<std::uint32_t>(place - positions.begin()));
  }
  return Search(memory.subset, parts, parameters, ordered ? &memory.order : nullptr, deadline, memory).run();
}

}  // namespace corrsel::core
