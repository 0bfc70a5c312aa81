#include "corrsel/selectors/auto.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "auto/leftover.h"
#include "auto/local_support.h"
#include "auto/parallax.h"
#include "auto/plausibility.h"
#include "base/deadline.h"
#include "base/gather.h"
#include "base/text.h"
#include "base/workspace_scope.h"
#include "corrsel/selectors/planes.h"
#include "geometry/normalization.h"
#include "geometry/residual.h"
#include "search/affine_growing.h"
#include "search/frame_proposal.h"
#include "search/fundamental_model.h"
#include "search/homography_model.h"
#include "search/local_optimization.h"
#include "search/local_proposal.h"
#include "search/ordering.h"
#include "search/prosac_proposal.h"
#include "search/search.h"
#include "search/significance.h"
#include "search/support.h"
#include "search/uniform_proposal.h"
#include "search/verifier.h"
#include "selectors/parts/sequential_planes.h"

namespace corrsel::core {

AutoOptions::AutoOptions() { min_confidence = kBelievedConfidence; }

void AutoOptions::visit(OptionVisitor& visitor) const {
  visitor.choice("model",
                 {{Model::kAuto, "auto", "Found out from the matches"},
                  {Model::kHomography, "homography", "Planes, or cameras that only turn"},
                  {Model::kFundamental, "fundamental", "Epipolar geometry of rigid scenes"}},
                 "Model to which the answer is restricted", &AutoOptions::model);
  visitor.number({"threshold", 0.01, 1000, "px",
                  "Inlier threshold of a homography: the smaller one of the transfer errors in both images"},
                 &AutoOptions::threshold);
  visitor.number({"fundamental_threshold", 0.01, 1000, "px",
                  "Inlier threshold of a fundamental matrix: Sampson distance"},
                 &AutoOptions::fundamental_threshold);
  visitor.integer({"hard_search", 0, 10000000, "-",
                   "Hypotheses that are drawn where nothing else has found a model; 0 = none"},
                  &AutoOptions::hard_search);
  visitConfidence(visitor);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the samplers"}, &AutoOptions::seed);
  visitor.integer({"threads", 1, 256, "-", "Threads that may be used; the result does not depend on it"},
                  &AutoOptions::threads);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &AutoOptions::max_seconds);
}

Presets AutoSelector::presets() const {
  return {
      {"h", {{"model", "homography"}}}, {"f", {{"model", "fundamental"}}}, {"fast", {{"hard_search", "0"}}}};
}

namespace {

using Rows = std::vector<std::uint32_t>;
using Mask = std::vector<std::uint8_t>;

constexpr std::size_t kLeastMatches = 6;
constexpr float kLeastSeedSupport = 1;  // S of a seed
constexpr int kMostSeeds = 60;          // that are grown
constexpr int kFruitlessSeeds = 3;      // in a row, after which a model with many inliers is kept
constexpr double kWorthRefining = 0.7;  // gain of a candidate at the wide threshold, relative to the best
constexpr std::size_t kBestSupported = 200;  // matches that join the first search
constexpr int kFirstHypotheses = 2000, kSecondHypotheses = 5000, kFundamentalHypotheses = 300,
              kPlaneHypotheses = 300;
constexpr std::size_t kManyInliers = 40;  // which make the second search unnecessary, with
constexpr double kShareOfLocal = 0.6;     // this share of the local set
constexpr double kExplained = 0.9;        // share of the local set that makes all further search unnecessary
constexpr double kOutside = 2;            // times the threshold: what is farther away is not explained by H
constexpr std::size_t kLeastLocal = 12;   // members of the local set that F is estimated from
constexpr double kLooseShare = 0.08;      // of the matches off the plane: a loose leftover
constexpr double kTwoTier = 2;            // local support allows this many times the error of F
constexpr double kExplainedByF = 3;       // times the threshold: a member of the local set is explained by F
constexpr double kRoughScene = 20;  // times what chance gives: many matches that agree with F without local
                                    // support mean depth that jumps

/// Memory that is kept between calls.
struct AutoMemory {
  Ordering ordering;
  Rows rows, best_first, identity;
  Correspondences matches;  // in random order, the order of everything below
  NormalizedMatches normalized;
  LocalSupport support;
  AffineGrowing growing;
  DistinctSupport distinct;
  Leftover leftover;
  Plausibility plausibility;
  ParallaxTest parallax;
  SignificanceTest significance;
  FrameProposal frames;
  SequentialPlanes planes;
  Rows by_support, rank, searched, rest;
  Mask taken, plane, explained, answer, core;
  std::vector<double> plane_errors, epipolar_errors;
};

std::size_t count(const Mask& mask) {
  return static_cast<std::size_t>(std::accumulate(mask.begin(), mask.end(), 0));
}

/// The stages of the selector on one input.
class Stages {
 public:
  Stages(const Correspondences& matches, const AutoOptions& options, Workspace& workspace);

  void run(Selection& result);

 private:
  using Residual = core::Residual;

  double squaredThreshold() const { return options_.threshold * options_.threshold; }
  double squaredEpipolar() const { return options_.fundamental_threshold * options_.fundamental_threshold; }
  static bool isBelieved(double confidence) { return confidence >= kBelievedConfidence; }

  void sortBySupport();
  void findHomography();
  void growSeeds();
  void search(const Rows& order, int hypotheses);
  void searchFrames();
  void takeBest(const SearchOutcome& outcome);
  void consider(const cv::Matx33d& normalized);
  void judgeHomography();
  bool explainsLocalSet() const;
  void findFundamental(const Rows& members);
  void chooseModel(Selection& result);
  void selectFundamental(bool single_model, Selection& result);
  void selectHomography(Selection& result, const char* found);
  void addMotions(Selection& result);
  void finish(const Mask& mask, Selection& result, double confidence, const std::string& found);
  void reportTimeLimit(Selection& result) const;

  SearchParameters parameters(double threshold, int hypotheses) const;

  const AutoOptions& options_;
  Workspace& workspace_;
  AutoMemory& work_;
  const Deadline deadline_;
  const Correspondences& matches_;
  const std::size_t n_;
  bool timed_out_ = false;
  std::uint64_t hypotheses_ = 0;

  Verifier wide_, narrow_;      // 10 and 7 px for a threshold of 5 px
  std::int64_t best_gain_ = 0;  // of a candidate over no model, judged by wide_
  Candidate plane_;             // normalised, judged by narrow_
  double plane_confidence_ = 0;
  cv::Matx33d homography_ = cv::Matx33d::zeros();
  bool has_fundamental_ = false;
  double fundamental_confidence_ = 0;
  cv::Matx33d fundamental_ = cv::Matx33d::zeros();
};

/// The order of everything that follows: random, and independent of the order of the input.
const Correspondences& ordered(const Correspondences& matches, const AutoOptions& options, AutoMemory& work) {
  work.ordering.shuffle(matches, static_cast<std::uint64_t>(options.seed), work.rows);
  gather(matches, work.rows, work.matches);
  work.identity.resize(matches.size());
  std::iota(work.identity.begin(), work.identity.end(), 0U);
  normalizeMatches(work.matches, work.identity, work.normalized);
  if (!work.ordering.byQuality(work.matches, work.identity, work.best_first)) work.best_first = work.identity;
  work.distinct.group(work.normalized, work.normalized.scale);
  return work.matches;
}

Stages::Stages(const Correspondences& matches, const AutoOptions& options, Workspace& workspace)
    : options_(options),
      workspace_(workspace),
      work_(workspace.part<AutoMemory>()),
      deadline_(options.max_seconds),
      matches_(ordered(matches, options, work_)),
      n_(matches.size()),
      wide_(work_.normalized, Residual::kSymmetricTransfer, 2 * options.threshold * work_.normalized.scale,
            true, &work_.distinct),
      narrow_(work_.normalized, Residual::kSymmetricTransfer,
              std::sqrt(2.0) * options.threshold * work_.normalized.scale, true, &work_.distinct) {
  work_.significance.assign(matches_);
  work_.leftover.assign(matches_);
}

SearchParameters Stages::parameters(double threshold, int hypotheses) const {
  SearchParameters parameters;
  parameters.threshold = threshold;
  parameters.max_iterations = hypotheses;
  parameters.seed = static_cast<std::uint64_t>(options_.seed);
  return parameters;
}

/// Writes all matches by falling support, then by quality.
void Stages::sortBySupport() {
  const std::vector<float>& support = work_.support.support();
  work_.rank.resize(n_);
  for (std::uint32_t k = 0; k < n_; ++k) work_.rank[work_.best_first[k]] = k;
  work_.by_support = work_.best_first;
  // A stable sort would allocate memory.
  std::sort(work_.by_support.begin(), work_.by_support.end(), [&](std::uint32_t a, std::uint32_t b) {
    return support[a] != support[b] ? support[a] > support[b] : work_.rank[a] < work_.rank[b];
  });
}

/// Refines a homography on all matches and keeps it if it is the best one so far.
void Stages::consider(const cv::Matx33d& normalized) {
  const HomographyModel problem(Residual::kSymmetricTransfer);
  Candidate candidate;
  if (!wide_.improve(normalized, candidate)) return;
  optimizeLocally(problem, wide_, candidate);
  const std::int64_t gain = static_cast<std::int64_t>(n_) * ScoreRule::kOutlierCost - candidate.cost;
  if (static_cast<double>(gain) < kWorthRefining * static_cast<double>(best_gain_)) return;
  best_gain_ = std::max(best_gain_, gain);
  Candidate refined;
  if (!narrow_.improve(candidate.model, refined)) return;
  optimizeLocally(problem, narrow_, refined);
  if (refined.cost < plane_.cost) plane_ = refined;
}

void Stages::growSeeds() {
  work_.growing.assign(matches_, work_.support.weights(), work_.support.diagonal());
  work_.taken.assign(n_, 0);
  int grown = 0, last_better = 0;
  for (const std::uint32_t seed : work_.by_support) {
    if (work_.support.support()[seed] < kLeastSeedSupport || grown == kMostSeeds) break;
    if (work_.taken[seed] != 0) continue;
    ++grown;
    const bool found = work_.growing.grow(seed, work_.support.maps()[seed]);
    for (const std::uint32_t i : work_.growing.supporters()) work_.taken[i] = 1;
    if (!found) continue;
    if (plane_.inliers >= kManyInliers && grown - last_better > kFruitlessSeeds) break;
    const std::int64_t before = plane_.cost;
    consider(work_.normalized.homographyFromPixels(work_.growing.map()));
    if (plane_.cost < before) {
      last_better = grown;
      if (explainsLocalSet()) break;
    }
    if (deadline_.passed()) {
      timed_out_ = true;
      break;
    }
  }
  hypotheses_ += static_cast<std::uint64_t>(grown);
}

/// Searches by PROSAC in the given order.
void Stages::search(const Rows& order, int hypotheses) {
  const HomographyModel model;
  if (timed_out_ || order.size() < static_cast<std::size_t>(model.traits.sample_size)) return;
  takeBest(core::search(work_.normalized, {model, workspace_.part<ProsacProposal>()},
                        parameters(options_.threshold, hypotheses), &order, deadline_, workspace_));
}

/// Searches among the maps that the frames of single matches give, where there are frames.
void Stages::searchFrames() {
  if (timed_out_ || matches_.left_frame.empty() || matches_.right_frame.empty()) return;
  work_.frames.read(matches_, work_.identity, &work_.by_support);
  takeBest(core::search(work_.normalized, {HomographyModel(), work_.frames},
                        parameters(options_.threshold, 0), nullptr, deadline_, workspace_));
}

void Stages::takeBest(const SearchOutcome& outcome) {
  hypotheses_ += static_cast<std::uint64_t>(outcome.iterations);
  timed_out_ = timed_out_ || outcome.timed_out;
  if (outcome.best.exists()) consider(outcome.best.model);
}

/// Computes errors, mask and confidence of the best homography.
void Stages::judgeHomography() {
  work_.plane_errors.resize(n_);
  work_.plane.assign(n_, 0);
  plane_confidence_ = 0;
  if (!plane_.exists()) {
    std::fill(work_.plane_errors.begin(), work_.plane_errors.end(), std::numeric_limits<double>::infinity());
    return;
  }
  homography_ = work_.normalized.homographyToPixels(plane_.model);
  pixelErrors(Residual::kSmallerTransfer, homography_, matches_, work_.plane_errors.data());
  for (std::size_t i = 0; i < n_; ++i) work_.plane[i] = work_.plane_errors[i] <= squaredThreshold() ? 1 : 0;
  plane_confidence_ = work_.significance.homography(homography_, hypotheses_).confidence;
}

/// Whether the best homography leaves next to nothing of the local set over.
bool Stages::explainsLocalSet() const {
  const cv::Matx33d homography = work_.normalized.homographyToPixels(plane_.model);
  pixelErrors(Residual::kSmallerTransfer, homography, matches_, work_.plane_errors.data());
  std::size_t explained = 0;
  for (std::size_t i = 0; i < n_; ++i)
    explained +=
        work_.support.local()[i] != 0 && work_.plane_errors[i] <= kOutside * kOutside * squaredThreshold()
            ? 1
            : 0;
  return explained >= kManyInliers &&
         static_cast<double>(explained) >= kExplained * static_cast<double>(work_.support.localSize());
}

void Stages::findHomography() {
  work_.plane_errors.resize(n_);
  growSeeds();
  if (plane_.exists() && explainsLocalSet()) {
    judgeHomography();
    if (isBelieved(plane_confidence_)) return;
  }
  // The local set, the survivors and the best supported matches, in the order of support.
  work_.taken = work_.support.local();
  for (const std::uint32_t i : work_.support.survivors()) work_.taken[i] = 1;
  for (std::size_t i = 0; i < std::min(kBestSupported, n_); ++i) {
    const std::uint32_t row = work_.by_support[i];
    if (work_.support.support()[row] > 0) work_.taken[row] = 1;
  }
  work_.searched.clear();
  for (const std::uint32_t i : work_.by_support)
    if (work_.taken[i] != 0) work_.searched.push_back(i);
  search(work_.searched, kFirstHypotheses);
  judgeHomography();
  const bool enough =
      isBelieved(plane_confidence_) && plane_.distinct >= kManyInliers &&
      static_cast<double>(plane_.distinct) >= kShareOfLocal * static_cast<double>(work_.support.localSize());
  if (enough || timed_out_) return;
  searchFrames();
  search(work_.by_support, kSecondHypotheses);
  judgeHomography();
  if (isBelieved(plane_confidence_) || options_.hard_search == 0 || timed_out_) return;
  search(work_.best_first, options_.hard_search);
  judgeHomography();
}

void Stages::findFundamental(const Rows& members) {
  SearchParameters parameters = this->parameters(options_.fundamental_threshold, kFundamentalHypotheses);
  parameters.confidence = 1;  // all of them: the first good model is often good in a part of the scene only
  const FundamentalModel problem;
  if (timed_out_ || members.size() < static_cast<std::size_t>(problem.traits.sample_size)) return;
  const SearchOutcome outcome = core::search(work_.normalized, {problem, workspace_.part<UniformProposal>()},
                                             parameters, &members, deadline_, workspace_);
  hypotheses_ += static_cast<std::uint64_t>(outcome.iterations);
  timed_out_ = timed_out_ || outcome.timed_out;
  if (!outcome.best.exists()) return;
  const Verifier verifier(work_.normalized, Residual::kSampson,
                          options_.fundamental_threshold * work_.normalized.scale, true);
  Candidate candidate;
  if (!verifier.improve(outcome.best.model, candidate)) return;
  optimizeLocally(problem, verifier, candidate);
  fundamental_ = work_.normalized.fundamentalToPixels(candidate.model);
  has_fundamental_ = true;
}

void Stages::finish(const Mask& mask, Selection& result, double confidence, const std::string& found) {
  result.score.resize(n_);
  for (std::size_t i = 0; i < n_; ++i) {
    const std::uint32_t row = work_.rows[i];
    result.mask[row] = mask[i];
    result.score[row] = work_.support.support()[i];
  }
  result.confidence = confidence;
  result.iterations = static_cast<int>(std::min<std::uint64_t>(hypotheses_, std::numeric_limits<int>::max()));
  result.message = found;
}

void Stages::selectHomography(Selection& result, const char* found) {
  result.model_kind = ModelKind::kHomography;
  result.model = homography_;
  finish(work_.plane, result, plane_confidence_, found);
}

/// Adds to the answer, which so far holds what agrees with the model, the planes of other motions and the
/// extended local set, and numbers the motions.
void Stages::addMotions(Selection& result) {
  const Mask& extended = work_.support.extended();
  work_.rest.clear();
  for (std::uint32_t i = 0; i < n_; ++i)
    if (work_.answer[i] == 0 && work_.explained[i] == 0) work_.rest.push_back(i);
  work_.searched.clear();
  for (const std::uint32_t i : work_.by_support)
    if (extended[i] != 0) work_.searched.push_back(i);
  PlanesOptions options;
  options.max_iterations = kPlaneHypotheses;
  options.seed = options_.seed;
  Selection remarks;
  work_.planes.find(matches_, work_.rest, &work_.searched,
                    {HomographyModel(), workspace_.part<LocalProposal>()}, options, deadline_, workspace_,
                    remarks);
  hypotheses_ += static_cast<std::uint64_t>(work_.planes.outcome().iterations);
  timed_out_ = timed_out_ || work_.planes.outcome().timed_out;
  result.group.resize(n_);
  for (std::size_t i = 0; i < n_; ++i) {
    const std::int32_t plane = work_.planes.group()[i];
    result.group[work_.rows[i]] = work_.answer[i] != 0 ? 0 : plane >= 0 ? plane + 1 : -1;
    work_.answer[i] |= plane >= 0 || extended[i] != 0 ? 1 : 0;
  }
}

/// Selects what agrees with the fundamental matrix and its surroundings.
void Stages::selectFundamental(bool single_model, Selection& result) {
  const Mask &local = work_.support.local(), &extended = work_.support.extended();
  const std::vector<double>& errors = work_.epipolar_errors;
  const double squared = squaredEpipolar();
  work_.answer.assign(n_, 0);
  work_.core.assign(n_, 0);
  work_.explained.assign(n_, 0);
  std::size_t unsupported = 0, agreeing = 0;
  for (std::size_t i = 0; i < n_; ++i) {
    const bool agrees = errors[i] <= squared;
    work_.answer[i] = agrees || (extended[i] != 0 && errors[i] <= kTwoTier * kTwoTier * squared) ? 1 : 0;
    work_.core[i] = local[i] != 0 && work_.answer[i] != 0 ? 1 : 0;
    work_.explained[i] =
        agrees || (local[i] != 0 && errors[i] <= kExplainedByF * kExplainedByF * squared) ? 1 : 0;
    unsupported += agrees && extended[i] == 0 ? 1 : 0;
    agreeing += agrees ? 1 : 0;
  }
  const double chance = 2 * std::sqrt(2.0) * options_.fundamental_threshold / std::sqrt(work_.support.area());
  if (static_cast<double>(unsupported) < kRoughScene * chance * static_cast<double>(n_ - agreeing))
    work_.plausibility.filter(matches_, work_.support.maps(), work_.core, work_.answer);
  result.model_kind = ModelKind::kFundamental;
  result.model = fundamental_;
  const std::size_t left_over = work_.leftover.coherent(local, work_.explained);
  if (single_model || !work_.leftover.isSizable(left_over, count(work_.explained))) {
    finish(work_.answer, result, fundamental_confidence_, "epipolar geometry of a rigid scene");
    return;
  }
  addMotions(result);
  finish(work_.answer, result,
         std::max(fundamental_confidence_, work_.significance.local(work_.answer).confidence),
         "several motions; the fundamental matrix holds for one of them");
}

void Stages::chooseModel(Selection& result) {
  const Mask& local = work_.support.local();
  const bool believed = isBelieved(plane_confidence_);
  if (options_.model == AutoOptions::Model::kHomography) {
    if (plane_.exists()) return selectHomography(result, "a plane or a camera that only turns");
    result.status = Status::kNoModel;
    result.message = "no homography was found";
    return;
  }
  // What is left over: coherently, farther than twice the threshold, and loosely, farther than the threshold.
  bool coherent = true, loose = false;
  std::size_t loose_matches = 0;
  if (believed && options_.model == AutoOptions::Model::kAuto) {
    const std::size_t on_plane = count(work_.plane);
    work_.explained.resize(n_);
    work_.taken.resize(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      work_.explained[i] = work_.plane_errors[i] <= kOutside * kOutside * squaredThreshold() ? 1 : 0;
      work_.taken[i] = local[i] != 0 && work_.plane[i] == 0 ? 1 : 0;
    }
    coherent =
        work_.leftover.isSizable(work_.leftover.coherent(local, work_.explained), count(work_.explained));
    loose_matches = count(work_.taken);
    const std::size_t loose_places = work_.leftover.distinctPlaces(work_.taken);
    loose = work_.leftover.isSizable(loose_places, on_plane) &&
            static_cast<double>(loose_places) > kLooseShare * static_cast<double>(n_ - on_plane);
    if (!coherent && !loose) {
      has_fundamental_ =
          work_.parallax.find(matches_, work_.normalized, work_.best_first, plane_.model, work_.plane_errors,
                              work_.support.area(), {options_.threshold, options_.fundamental_threshold},
                              static_cast<std::uint64_t>(options_.seed), fundamental_);
      if (!has_fundamental_) return selectHomography(result, "a plane or a camera that only turns");
    }
  }
  if (!has_fundamental_ && work_.support.localSize() >= kLeastLocal) {
    work_.searched.clear();
    for (std::uint32_t i = 0; i < n_; ++i)
      if (local[i] != 0) work_.searched.push_back(i);
    findFundamental(work_.searched);
  }
  if (has_fundamental_) {
    work_.epipolar_errors.resize(n_);
    pixelErrors(Residual::kSampson, fundamental_, matches_, work_.epipolar_errors.data());
    fundamental_confidence_ = work_.significance.fundamental(fundamental_, hypotheses_).confidence;
  }
  if (options_.model == AutoOptions::Model::kFundamental) {
    if (has_fundamental_) return selectFundamental(true, result);
    result.status = Status::kNoModel;
    result.message = "no fundamental matrix was found";
    return;
  }
  const bool believed_fundamental = has_fundamental_ && isBelieved(fundamental_confidence_);
  if (believed && loose && !coherent) {
    std::size_t explained = 0;
    for (std::size_t i = 0; i < n_ && believed_fundamental; ++i)
      explained += work_.taken[i] != 0 && work_.epipolar_errors[i] <= squaredEpipolar() ? 1 : 0;
    if (2 * explained < loose_matches)
      return selectHomography(result, "a plane; local matches are imprecise");
  }
  if (believed_fundamental) return selectFundamental(false, result);
  const double local_confidence = work_.significance.local(work_.support.extended()).confidence;
  if (believed) {
    if (!coherent || !isBelieved(local_confidence))
      return selectHomography(result, "a plane or a camera that only turns");
    work_.answer = work_.plane;
    addMotions(result);
    result.model_kind = ModelKind::kHomography;
    result.model = homography_;
    return finish(work_.answer, result, std::max(plane_confidence_, local_confidence),
                  "several motions; the homography holds for one of them");
  }
  if (local_confidence > plane_confidence_ || !plane_.exists()) {
    finish(work_.support.extended(), result, local_confidence, "matches that agree with their surroundings");
    if (work_.support.survivors().empty()) {
      result.status = Status::kNoModel;
      result.message = "nothing agrees more than by chance";
    }
    return;
  }
  selectHomography(result, "a plane or a camera that only turns");
}

void Stages::run(Selection& result) {
  work_.support.compute(matches_, work_.best_first, options_.threads);
  timed_out_ = deadline_.passed();
  if (!timed_out_) {
    sortBySupport();
    if (options_.model != AutoOptions::Model::kFundamental) findHomography();
    chooseModel(result);
  }
  if (timed_out_) reportTimeLimit(result);
}

void Stages::reportTimeLimit(Selection& result) const {
  if (hypotheses_ == 0) {
    result = Selection{};
    result.mask.assign(n_, 0);
  }
  result.status = hypotheses_ == 0 ? Status::kTooLarge : Status::kTimeLimit;
  result.message += (result.message.empty() ? "" : "; ") + std::string("stopped after ") +
                    std::to_string(hypotheses_) +
                    " hypotheses, max_seconds = " + formatNumber(options_.max_seconds);
}

}  // namespace

void AutoSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  if (matches.size() < kLeastMatches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(matches.size()) + " matches, auto needs " + std::to_string(kLeastMatches);
    return;
  }
  if (allEqual(matches.left_x, matches.left_y) || allEqual(matches.right_x, matches.right_y)) {
    result.status = Status::kDegenerate;
    result.message = "all points of one image are equal";
    return;
  }
  Stages(matches, options_, workspace).run(result);
}

}  // namespace corrsel::core
