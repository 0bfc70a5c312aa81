#include "search/search.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/deadline.h"
#include "base/text.h"
#include "base/workspace_scope.h"
#include "geometry/residual.h"
#include "search/degensac.h"
#include "search/frame_hypotheses.h"
#include "search/local_optimization.h"
#include "search/mlesac.h"
#include "search/ordering.h"
#include "search/sampler.h"
#include "search/significance.h"
#include "search/sprt.h"
#include "search/stopping.h"
#include "search/two_view.h"
#include "search/verifier.h"

namespace corrsel::core {
namespace {

/// Memory of a search that is kept between calls.
struct SearchMemory {
  std::vector<float> errors;
  Degensac::Scratch degensac;
  DistinctSupport distinct;
  MatchNeighbourhood near;
  GrowingNeighbourhoods growing;
  HypothesisAffinity affinity;
  std::vector<double> densities;    // of the errors, for MLESAC
  std::vector<std::uint8_t> first;  // whether a match is the best one of its points by quality
  // The matches that take part, where they are not all.
  NormalizedMatches subset;
  std::vector<std::uint32_t> positions, order;
};

/// Memory of searchConsensus() that is kept between calls.
struct SelectionMemory {
  Ordering ordering;
  std::vector<std::uint32_t> rows;        // input rows in random order: the order of everything below
  std::vector<std::uint32_t> best_first;  // the same numbers by quality
  std::vector<std::uint32_t> position;    // of each row in `rows`
  NormalizedMatches matches;
  std::vector<double> pixel_errors;
};

class Search {
 public:
  /// @param matches     those that take part, in random order
  /// @param best_first  all of them by quality; nullptr = uniform samples
  /// @param frames      homographies that are tried before any sample; nullptr = none
  Search(const NormalizedMatches& matches, const ConsensusOptions& options, const TwoViewProblem& problem,
         double threshold, const std::vector<std::uint32_t>* best_first, FrameHypotheses* frames,
         const Deadline& deadline, SearchMemory& work)
      : matches_(matches),
        options_(options),
        problem_(problem),
        best_first_(best_first),
        frames_(frames),
        deadline_(deadline),
        work_(work),
        one_to_one_(options.one_to_one && problem.kind == ModelKind::kHomography),
        verifier_(matches, problem.residual, problem.search_width * threshold * matches.scale,
                  options.score != ConsensusOptions::Score::kInlierCount,
                  one_to_one_ ? &work.distinct : nullptr),
        most_iterations_(options.max_iterations > 0 ? options.max_iterations : defaultIterations()),
        sampler_(makeSampler()),
        stopping_(options.confidence, countDistinct(threshold), problem.sample_size),
        degensac_(seed() + 1, work.degensac) {
    if (options.score == ConsensusOptions::Score::kMlesac) mixture_ = mixture();
    if (options.sprt) {
      sprt_.emplace(sprtConstants(), problem.sample_size / static_cast<double>(matches.size()));
      stopping_.setLoss(sprt_->loss(), 0);
    }
  }

  /// @return the best model found
  Candidate run(int& iterations) {
    std::uint32_t sample[TwoViewProblem::kLargestSample];
    cv::Matx33d models[TwoViewProblem::kMostModels];
    if (frames_ != nullptr) tryFrames(iterations);
    if (options_.sampler == ConsensusOptions::Sampler::kFrames || timed_out_) return best_;
    // Samples of crowded matches that the check refuses count as hypotheses, because most of those among
    // wrong matches are refused.
    const bool crowded = options_.sampler == ConsensusOptions::Sampler::kLocal || drawsByAffinity();
    const double most_samples = crowded ? most_iterations_ : samplesForLeastSignificance();
    for (; iterations < most_iterations_ && !stopping_.enough(sampler_.drawn()); ++iterations) {
      if (static_cast<double>(sampler_.drawn()) >= most_samples || outOfTime()) break;
      no_valid_sample_ = !drawValidSample(sample);
      if (no_valid_sample_) break;
      const int count = problem_.solve(matches_, sample, models);
      for (int k = 0; k < count; ++k) {
        tryModel(models[k], sample);
        if (drawsByAffinity()) addToAffinity(models[k]);
      }
    }
    if (best_.exists() && options_.refine && !optimized_) optimizeLocally(problem_, verifier_, best_);
    return best_;
  }

  /// Whether the time limit ended the search.
  bool timedOut() const { return timed_out_; }

  /// Whether the search ended because no sample passed the check.
  bool foundNoSample() const { return no_valid_sample_; }

 private:
  // For max_iterations 0. With the order by quality, fewer samples find as much as uniform samples do.
  static constexpr int kOrderedIterations = 100000, kUniformIterations = 850000;
  static constexpr int kAffinityIterations = 5000;  // every one of them takes O(N)

  int defaultIterations() const {
    if (drawsByAffinity()) return kAffinityIterations;
    return best_first_ != nullptr ? kOrderedIterations : kUniformIterations;
  }

  bool drawsByAffinity() const { return options_.sampler == ConsensusOptions::Sampler::kMultigs; }

  void addToAffinity(const cv::Matx33d& model) {
    modelErrors(problem_.residual, model, matches_, 0, matches_.size(), work_.affinity.next());
    work_.affinity.add();
  }

  Sampler makeSampler() {
    if (drawsByAffinity()) {
      work_.affinity.start(matches_.size());
      return {work_.affinity, matches_.size(), problem_.sample_size, seed()};
    }
    if (options_.sampler == ConsensusOptions::Sampler::kPnapsac && best_first_ != nullptr) {
      work_.growing.build(matches_, *best_first_, problem_.sample_size);
      return {work_.growing, *best_first_, problem_.sample_size, seed(), problem_.prosac};
    }
    if (options_.sampler == ConsensusOptions::Sampler::kLocal) {
      work_.near.build(matches_);
      return {work_.near, matches_.size(), best_first_, problem_.sample_size, seed(), problem_.prosac};
    }
    if (best_first_ != nullptr) return {*best_first_, problem_.sample_size, seed(), problem_.prosac};
    return {matches_.size(), problem_.sample_size, seed()};
  }

  /// Returns the number of matches that count, and prepares the count if every point counts once.
  std::size_t countDistinct(double threshold) {
    if (!one_to_one_) return matches_.size();
    // Points that are closer together than the threshold would not differ in another unit either.
    work_.distinct.group(matches_, std::min(1.0, threshold) * matches_.scale);
    if (best_first_ != nullptr) work_.distinct.markFirst(*best_first_, work_.first);
    return work_.distinct.distinctMatches();
  }

  /// Returns whether the time limit has passed. Reads the clock once in kSamplesPerLook samples, which take
  /// well below a millisecond, and after each new best model, which may take longer. Samples by affinity take
  /// O(N) each.
  bool outOfTime() {
    constexpr std::uint64_t kSamplesPerLook = 100;
    if (sampler_.drawn() < next_look_) return false;
    next_look_ = sampler_.drawn() + (drawsByAffinity() ? 1 : kSamplesPerLook);
    timed_out_ = deadline_.passed();
    return timed_out_;
  }

  /// Number of samples after which a further search cannot gain anything: the smallest support that chance
  /// does not explain, if all its matches lay within a pixel of the model, would have been drawn. Matters
  /// where there are few matches, since their smallest significant support is a large share of them.
  double samplesForLeastSignificance() const {
    constexpr double kTests = 8e4;  // hypotheses times thresholds, as in SignificanceTest
    constexpr double kLeastSamples = 1e4, kLargestLoss = 1.0 / 8;
    constexpr double kNever = std::numeric_limits<double>::infinity();
    const std::size_t n = matches_.size(), m = static_cast<std::size_t>(problem_.sample_size);
    if (options_.confidence >= 1) return kNever;
    const auto [width, height] = rightExtent();
    const double chance =
        std::min(1.0, problem_.chanceWithinOne(width / matches_.scale, height / matches_.scale));
    std::size_t support = m + 1;
    while (support < n && std::log10(kTests) + log10BinomialTail(n - m, support - m, chance) > 0) ++support;
    double all_inliers = 1;
    for (std::size_t k = 0; k < m; ++k)
      all_inliers *= static_cast<double>(support - k) / static_cast<double>(n - k);
    return std::max(kLeastSamples,
                    std::log1p(-options_.confidence) / std::log1p(-all_inliers * (1 - kLargestLoss)));
  }

  SprtConstants sprtConstants() const {
    SprtConstants constants = problem_.sprt;
    constants.epsilon = options_.sprt_inlier_ratio > 0 ? options_.sprt_inlier_ratio : smallestTestedRatio();
    return constants;
  }

  /// Inlier ratio for which the SPRT is designed. The search can find models down to the inlier ratio at
  /// which as many uniform samples as it may draw contain one without an outlier with a probability of 99.9
  /// %. The model of a noisy sample agrees with about three of ten matches that are right. PROSAC finds rarer
  /// models, as if it drew a million samples at least.
  double smallestTestedRatio() const {
    constexpr double kLogMissed = -6.9078, kProsacSamples = 1e6, kAgreeing = 0.3;
    const double samples =
        best_first_ != nullptr ? std::max<double>(most_iterations_, kProsacSamples) : most_iterations_;
    const double all_inliers = -std::expm1(kLogMissed / samples);
    return kAgreeing * std::pow(all_inliers, 1.0 / problem_.sample_size);
  }

  std::uint64_t seed() const { return static_cast<std::uint64_t>(options_.seed); }

  bool drawValidSample(std::uint32_t* sample) {
    // As in OpenCV, so many refusals mean that there is no valid sample.
    constexpr int kMostRefusals = 10000;
    // Limits the average number of samples per hypothesis, for data with hardly any valid sample.
    constexpr std::uint64_t kSamplesPerHypothesis = 50;
    const std::uint64_t most =
        kMostRefusals + kSamplesPerHypothesis * static_cast<std::uint64_t>(most_iterations_);
    for (int refused = 0; refused < kMostRefusals && sampler_.drawn() < most; ++refused) {
      if (drawsByAffinity() && outOfTime()) return false;
      sampler_.draw(sample);
      if (problem_.isValidSample(matches_, sample)) return true;
    }
    return false;
  }

  /// Refines the maps from local frames, which are rough, and keeps the best one.
  void tryFrames(int& iterations) {
    constexpr int kMostMaps = 60;
    constexpr std::size_t kManyInliers = 40;  // with which the search ends after
    constexpr int kFruitless = 3;             // maps that bring nothing better
    for (int fruitless = 0; iterations < std::min(kMostMaps, most_iterations_); ++iterations) {
      if (best_.distinct >= kManyInliers && fruitless > kFruitless) break;
      timed_out_ = deadline_.passed();
      if (timed_out_ || !frames_->next()) break;
      ++fruitless;
      Candidate candidate;
      if (frames_->map() == nullptr ||
          !verifier_.improve(matches_.homographyFromPixels(*frames_->map()), candidate))
        continue;
      optimizeLocally(problem_, verifier_, candidate);
      if (candidate.cost >= best_.cost) continue;
      best_ = candidate;
      fruitless = 0;
    }
    optimized_ = true;
  }

  void tryModel(const cv::Matx33d& model, const std::uint32_t* sample) {
    const bool mlesac = options_.score == ConsensusOptions::Score::kMlesac;
    const std::int64_t limit = mlesac ? limitOfLikelihood() : best_.cost;
    const ModelScore score = sprt_ ? verifier_.test(model, limit, *sprt_) : verifier_.score(model, limit);
    if (score.rejected_by_sprt && sprt_->addRejected(score))
      stopping_.setLoss(sprt_->loss(), sampler_.drawn());
    if (score.rejected) return;
    if (mlesac) {
      const double cost = likelihoodCost(model);
      if (cost >= lowest_likelihood_cost_) return;
      lowest_likelihood_cost_ = cost;
    }
    best_ = {model, score.cost, score.inliers, score.inliers - score.surplus};
    next_look_ = 0;
    optimized_ = false;
    if (options_.degensac && problem_.kind == ModelKind::kFundamental)
      degensac_.escape(verifier_, sample, best_);
    // A model with little more than its own sample is noise and not worth the steps.
    constexpr std::size_t kWorthwhile = 4;
    if (options_.local_optimization &&
        best_.distinct >= kWorthwhile * static_cast<std::size_t>(problem_.sample_size)) {
      optimizeLocally(problem_, verifier_, best_);
      optimized_ = true;
      if (mlesac) lowest_likelihood_cost_ = std::min(lowest_likelihood_cost_, likelihoodCost(best_.model));
    }
    lowest_cost_ = std::min(lowest_cost_, best_.cost);
    // A better model has at least as many inliers that count.
    const double ratio = static_cast<double>(best_.distinct) / static_cast<double>(matches_.size());
    if (sprt_ && sprt_->addBest(ratio)) stopping_.setLoss(sprt_->loss(), sampler_.drawn());
    stopping_.setInliers(best_.distinct);
    if (best_first_ != nullptr) stopByPrefix();
  }

  /// The computation of a likelihood cannot be given up early. Only models whose MSAC cost is near the lowest
  /// one are therefore compared by their likelihood: at most 1.5 times the cost, and at least two thirds of
  /// what the model saves in comparison with no inliers. (Where few matches are right, 1.5 times the cost
  /// excludes nothing.)
  std::int64_t limitOfLikelihood() const {
    if (!best_.exists()) return best_.cost;
    const auto none = static_cast<std::int64_t>(matches_.size()) * ScoreRule::kOutlierCost;
    return std::min(lowest_cost_ + lowest_cost_ / 2, none - (none - lowest_cost_) / 3 * 2);
  }

  double likelihoodCost(const cv::Matx33d& model) {
    const std::size_t n = matches_.size();
    work_.errors.resize(n);
    modelErrors(problem_.residual, model, matches_, 0, n, work_.errors.data());
    return fitMixture(work_.errors.data(), n, mixture_, work_.densities).cost;
  }

  /// The threshold is the bound within which 95 % of the errors of right matches lie. A wrong match may lie
  /// anywhere in the box of the right points.
  ErrorMixture mixture() const {
    constexpr double kBoundOfDistance[] = {1.96, 2.45};  // standard deviations, in one and two dimensions
    const bool points = problem_.kind == ModelKind::kHomography;
    const auto [width, height] = rightExtent();
    const double sigma = std::sqrt(double{verifier_.squaredThreshold()}) / kBoundOfDistance[points ? 1 : 0];
    const double range = points ? width * height : std::hypot(width, height);
    return {sigma, std::max(range, sigma * sigma), points ? 2 : 1};
  }

  /// Width and height of the box of the right points, normalised.
  std::pair<double, double> rightExtent() const {
    const auto [left, right] = std::minmax_element(matches_.right_x.begin(), matches_.right_x.end());
    const auto [top, bottom] = std::minmax_element(matches_.right_y.begin(), matches_.right_y.end());
    return {*right - *left, *bottom - *top};
  }

  /// Stopping condition of PROSAC. Considers the prefixes of the best matches from which all samples so far
  /// were drawn, that are long enough for the kind of model, and whose number of inliers is not explained by
  /// chance (inlier probability 5 %, confidence 95 %, normal approximation of the binomial tail). Takes the
  /// prefix with the largest share of inliers. Where every point counts once, only the best match of a point
  /// does.
  void stopByPrefix() {
    if (options_.sampler == ConsensusOptions::Sampler::kLocal) return;
    constexpr std::size_t kLeastPrefix = 20;
    constexpr double kChance = 0.05, kSquaredQuantile = 2.706;
    const std::size_t n = matches_.size(), m = static_cast<std::size_t>(problem_.sample_size);
    work_.errors.resize(n);
    modelErrors(problem_.residual, best_.model, matches_, 0, n, work_.errors.data());
    const auto share = static_cast<std::size_t>(problem_.least_prefix * static_cast<double>(n));
    const std::size_t least = std::max<std::size_t>({kLeastPrefix, sampler_.pool(), share});
    std::size_t inliers = 0, best_inliers = 0, best_pool = 1;
    std::size_t pool = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const std::uint32_t match = (*best_first_)[i];
      if (one_to_one_ && work_.first[match] == 0) continue;
      inliers += work_.errors[match] <= verifier_.squaredThreshold() ? 1 : 0;
      ++pool;
      if (i + 1 < least || inliers * best_pool <= best_inliers * pool) continue;
      const double mean = kChance * static_cast<double>(pool - m);
      const double enough =
          static_cast<double>(m) + mean + std::sqrt(kSquaredQuantile * mean * (1 - kChance));
      if (static_cast<double>(inliers) < enough) continue;
      best_inliers = inliers;
      best_pool = pool;
    }
    if (best_inliers > 0) stopping_.setPrefix(best_inliers, best_pool);
  }

  const NormalizedMatches& matches_;
  const ConsensusOptions& options_;
  const TwoViewProblem& problem_;
  const std::vector<std::uint32_t>* best_first_;
  FrameHypotheses* frames_;
  const Deadline& deadline_;
  SearchMemory& work_;
  bool one_to_one_;
  Verifier verifier_;
  ErrorMixture mixture_{};  // for MLESAC
  int most_iterations_;
  Sampler sampler_;
  StoppingRule stopping_;
  Degensac degensac_;
  std::optional<Sprt> sprt_;
  Candidate best_;
  std::int64_t lowest_cost_ = std::numeric_limits<std::int64_t>::max();  // of the best models by MLESAC
  double lowest_likelihood_cost_ = std::numeric_limits<double>::infinity();
  std::uint64_t next_look_ = 0;  // at the clock, samples
  bool optimized_ = false, timed_out_ = false, no_valid_sample_ = false;
};

/// Gathers the matches at the given positions, which keep their coordinates.
void gather(const NormalizedMatches& from, const std::vector<std::uint32_t>& positions,
            NormalizedMatches& to) {
  to.scale = from.scale;
  to.rounding = from.rounding;
  to.left = from.left;
  to.right = from.right;
  const auto gatherColumn = [&positions](const std::vector<float>& source, std::vector<float>& target) {
    target.resize(positions.size());
    for (std::size_t i = 0; i < positions.size(); ++i) target[i] = source[positions[i]];
  };
  gatherColumn(from.left_x, to.left_x);
  gatherColumn(from.left_y, to.left_y);
  gatherColumn(from.right_x, to.right_x);
  gatherColumn(from.right_y, to.right_y);
}

/// Whether the sampler begins with the best matches, and uniformly where it has no order of them.
bool drawsByQuality(ConsensusOptions::Sampler sampler) {
  return sampler == ConsensusOptions::Sampler::kProsac || sampler == ConsensusOptions::Sampler::kPnapsac;
}

/// Appends a remark to the message.
void addRemark(Selection& result, const std::string& text) {
  result.message += (result.message.empty() ? "" : "; ") + text;
}

/// Fits the model to its inliers at the threshold by which matches are selected, where it differs from that
/// of the search.
void fitToSelection(const NormalizedMatches& matches, const ConsensusOptions& options,
                    const TwoViewProblem& problem, double threshold, Candidate& best) {
  if (!options.refine || problem.final_width == problem.search_width) return;
  const Verifier verifier(matches, problem.residual, problem.final_width * threshold * matches.scale,
                          options.score != ConsensusOptions::Score::kInlierCount);
  Candidate fitted;
  verifier.improve(best.model, fitted);
  optimizeLocally(problem, verifier, fitted);
  best.model = fitted.model;
}

void report(const Correspondences& matches, const TwoViewProblem& problem, double threshold,
            const Candidate& best, SelectionMemory& work, Selection& result) {
  result.model = (work.matches.*problem.toPixels)(best.model);
  result.model_kind = problem.kind;
  const std::size_t inliers =
      selectByModel(matches, problem.mask_residual, threshold, work.pixel_errors, result);
  // Where every point counts once, the mask may hold more matches than count.
  if (std::min(inliers, best.distinct) <= static_cast<std::size_t>(problem.sample_size)) {
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

TwoViewProblem problemOf(const ConsensusOptions& options) {
  if (options.model == ModelKind::kFundamental) return fundamentalProblem();
  switch (options.error) {
    case ConsensusOptions::Error::kTransfer:
      return homographyProblem(Residual::kTransfer);
    case ConsensusOptions::Error::kSymmetricTransfer:
      return homographyProblem(Residual::kSymmetricTransfer);
    case ConsensusOptions::Error::kSmallerTransfer:
      break;
  }
  return homographyProblem(Residual::kSmallerTransfer);
}

std::size_t selectByModel(const Correspondences& matches, Residual residual, double threshold,
                          std::vector<double>& errors, Selection& result) {
  const std::size_t n = matches.size();
  errors.resize(n);
  pixelErrors(residual, result.model, matches, errors.data());
  result.score.resize(n);
  std::size_t inliers = 0;
  for (std::size_t i = 0; i < n; ++i) {
    result.score[i] = static_cast<float>(-errors[i]);
    result.mask[i] = errors[i] <= threshold * threshold ? 1 : 0;
    inliers += result.mask[i];
  }
  return inliers;
}

const std::vector<std::uint32_t>* orderForSampler(const Correspondences& matches,
                                                  const ConsensusOptions& options,
                                                  const std::vector<std::uint32_t>& rows, Ordering& ordering,
                                                  std::vector<std::uint32_t>& best_first, Selection& result) {
  const bool local = options.sampler == ConsensusOptions::Sampler::kLocal;
  if (!local && !drawsByQuality(options.sampler)) return nullptr;
  if (ordering.byQuality(matches, rows, best_first)) return &best_first;
  if (!local) {
    addRemark(result,
              std::string("the matches have no descriptor distances, so samples are drawn uniformly instead "
                          "of by ") +
                  (options.sampler == ConsensusOptions::Sampler::kProsac ? "PROSAC" : "Progressive NAPSAC"));
  }
  return nullptr;
}

FrameHypotheses* framesForSampler(const Correspondences& matches, const ConsensusOptions& options,
                                  const std::vector<std::uint32_t>& rows, Ordering& ordering,
                                  std::vector<std::uint32_t>& best_first) {
  if (options.sampler != ConsensusOptions::Sampler::kFrames) return nullptr;
  FrameHypotheses& frames = WorkspaceScope::part<FrameHypotheses>();
  frames.assign(matches, rows, ordering.byQuality(matches, rows, best_first) ? &best_first : nullptr);
  return &frames;
}

void reportEnd(const SearchOutcome& outcome, double max_seconds, Selection& result) {
  result.iterations = outcome.iterations;
  if (outcome.timed_out) {
    result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
    addRemark(result, "stopped after " + std::to_string(result.iterations) + " hypotheses" +
                          (outcome.best.exists() ? "" : ", none of them good enough") +
                          ", max_seconds = " + formatNumber(max_seconds));
  } else if (!outcome.best.exists() && outcome.no_valid_sample) {
    result.status = Status::kDegenerate;
    result.message = "no sample is valid: the matches are collinear, equal or differently oriented";
  } else if (!outcome.best.exists()) {
    result.status = Status::kNoModel;
    result.message = "no hypothesis could be fitted";
  }
}

bool isEnough(std::size_t matches, const TwoViewProblem& problem, Selection& result) {
  if (matches >= static_cast<std::size_t>(problem.sample_size)) return true;
  result.status = Status::kTooFew;
  result.message = std::to_string(matches) + " matches, a " + toString(problem.kind) + " needs " +
                   std::to_string(problem.sample_size);
  return false;
}

SearchOutcome searchModel(const NormalizedMatches& matches, const ConsensusOptions& options, double threshold,
                          const std::vector<std::uint32_t>* best_first, const Deadline& deadline,
                          FrameHypotheses* frames) {
  SearchMemory& work = WorkspaceScope::part<SearchMemory>();
  const bool ordered =
      drawsByQuality(options.sampler) || options.sampler == ConsensusOptions::Sampler::kLocal;
  const NormalizedMatches* taking_part = &matches;
  const std::vector<std::uint32_t>* order = best_first;
  if (best_first != nullptr && best_first->size() < matches.size()) {
    // Ascending positions keep the random order.
    work.positions = *best_first;
    std::sort(work.positions.begin(), work.positions.end());
    gather(matches, work.positions, work.subset);
    taking_part = &work.subset;
    if (ordered) {
      work.order.resize(best_first->size());
      std::transform(best_first->begin(), best_first->end(), work.order.begin(), [&work](std::uint32_t i) {
        return static_cast<std::uint32_t>(std::lower_bound(work.positions.begin(), work.positions.end(), i) -
                                          work.positions.begin());
      });
      order = &work.order;
    }
  }
  const TwoViewProblem problem = problemOf(options);
  Search search(*taking_part, options, problem, threshold, ordered ? order : nullptr, frames, deadline, work);
  SearchOutcome outcome;
  outcome.best = search.run(outcome.iterations);
  outcome.timed_out = search.timedOut();
  outcome.no_valid_sample = search.foundNoSample();
  return outcome;
}

void searchConsensus(const Correspondences& matches, const ConsensusOptions& options, double threshold,
                     Selection& result, const std::vector<std::uint32_t>* best_first) {
  const Deadline deadline(options.max_seconds);
  const TwoViewProblem problem = problemOf(options);
  const std::size_t n = best_first != nullptr ? best_first->size() : matches.size();
  if (!isEnough(n, problem, result)) return;
  SelectionMemory& work = WorkspaceScope::part<SelectionMemory>();
  work.ordering.shuffle(matches, static_cast<std::uint64_t>(options.seed), work.rows);
  normalizeMatches(matches, work.rows, work.matches);
  const std::vector<std::uint32_t>* order = nullptr;
  if (best_first != nullptr) {
    work.position.resize(matches.size());
    for (std::uint32_t i = 0; i < work.rows.size(); ++i) work.position[work.rows[i]] = i;
    work.best_first.resize(n);
    for (std::size_t i = 0; i < n; ++i) work.best_first[i] = work.position[(*best_first)[i]];
    order = &work.best_first;
  } else {
    order = orderForSampler(matches, options, work.rows, work.ordering, work.best_first, result);
  }
  FrameHypotheses* const frames =
      framesForSampler(matches, options, work.rows, work.ordering, work.best_first);
  SearchOutcome outcome = searchModel(work.matches, options, threshold, order, deadline, frames);
  reportEnd(outcome, options.max_seconds, result);
  if (!outcome.best.exists()) return;
  fitToSelection(work.matches, options, problem, threshold, outcome.best);
  report(matches, problem, threshold, outcome.best, work, result);
}

}  // namespace corrsel::core
