#include "corrsel/reference/tlinkage.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include "base/deadline.h"
#include "base/text.h"
#include "corrsel/random.h"
#include "geometry/fundamental.h"
#include "geometry/homography.h"
#include "geometry/normalization.h"
#include "geometry/residual.h"
#include "points/match_neighbours.h"
#include "reference/cluster_numbers.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kHomographySample = 4, kFundamentalSample = 7, kMaxModels = 3;  // of a sample
constexpr std::size_t kLevels = 3, kNeighbours[kLevels] = {8, 16, 32};
constexpr int kDraws = 10;          // samples until one is valid
constexpr double kReach = 5;        // of soft preferences, in units of tau
constexpr std::size_t kLook = 256;  // hypotheses between two readings of the clock
// Pairs of preferences for the same hypothesis, which take a fraction of a second to compare.
constexpr double kMaxPairs = 2e8;

/// The preference of a cluster for a hypothesis, listed by one of the two.
struct Preference {
  std::uint32_t of;
  float value;
};

/// Lists of preferences in one array.
struct Lists {
  std::vector<Preference> entries;
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> length;

  Preference* list(std::size_t k) { return entries.data() + begin[k]; }
};

/// Clusters of matches by their preferences for hypotheses.
class Linkage {
 public:
  /// @param by_hypothesis  the preferences of n matches for every hypothesis; changed by merging
  /// @return false where the deadline has passed
  bool start(std::size_t n, Lists& by_hypothesis, const Deadline& deadline) {
    n_ = n;
    by_hypothesis_ = &by_hypothesis;
    transpose();
    norm_.assign(n, 0.0);
    for (std::size_t i = 0; i < n; ++i) norm_[i] = squaredNorm(i);
    size_.assign(n, 1);
    parent_.resize(n);
    std::iota(parent_.begin(), parent_.end(), 0U);
    distance_.resize(n * n);
    dot_.assign(n, 0.0);
    nearest_.resize(n);
    for (std::uint32_t i = 0; i < n; ++i) {
      if (i % kLook == 0 && deadline.passed()) return false;
      findDistances(i);
    }
    for (std::uint32_t i = 0; i < n; ++i) findNearest(i);
    return true;
  }

  /// Merges the two closest clusters. @return false if none share a preference
  bool merge() {
    std::uint32_t a = 0;
    float smallest = 1;
    bool any = false;
    for (std::uint32_t i = 0; i < n_; ++i) {
      if (size_[i] == 0 || !(distance(i, nearest_[i]) < smallest)) continue;
      smallest = distance(i, nearest_[i]);
      a = i;
      any = true;
    }
    if (!any) return false;
    const std::uint32_t b = nearest_[a];
    intersect(a, b);
    size_[a] += size_[b];
    size_[b] = 0;
    parent_[b] = a;
    norm_[a] = squaredNorm(a);
    findDistances(a);
    for (std::uint32_t i = 0; i < n_; ++i) {
      if (size_[i] == 0 || i == a) continue;
      distance_[i * n_ + a] = distance(a, i);
      if (nearest_[i] == a || nearest_[i] == b) {
        findNearest(i);
      } else if (isCloser(i, a, nearest_[i])) {
        nearest_[i] = a;
      }
    }
    findNearest(a);
    return true;
  }

  /// The cluster of a match, the number of one of its matches.
  std::uint32_t clusterOf(std::uint32_t match) const {
    while (parent_[match] != match) match = parent_[match];
    return match;
  }

  /// The number of matches in every cluster.
  const std::vector<std::uint32_t>& sizes() const { return size_; }

 private:
  float distance(std::uint32_t i, std::uint32_t j) const { return distance_[i * n_ + j]; }

  /// Lists the preferences by match; hypotheses are in ascending order.
  void transpose() {
    const std::size_t hypotheses = by_hypothesis_->begin.size();
    of_.length.assign(n_, 0);
    for (const Preference& entry : by_hypothesis_->entries) ++of_.length[entry.of];
    of_.begin.assign(n_, 0);
    for (std::size_t i = 1; i < n_; ++i) of_.begin[i] = of_.begin[i - 1] + of_.length[i - 1];
    of_.entries.resize(by_hypothesis_->entries.size());
    of_.length.assign(n_, 0);
    for (std::uint32_t h = 0; h < hypotheses; ++h) {
      const Preference* const list = by_hypothesis_->list(h);
      for (std::size_t k = 0; k < by_hypothesis_->length[h]; ++k)
        of_.list(list[k].of)[of_.length[list[k].of]++] = {h, list[k].value};
    }
  }

  double squaredNorm(std::size_t i) {
    const Preference* const list = of_.list(i);
    double sum = 0;
    for (std::size_t k = 0; k < of_.length[i]; ++k) sum += double{list[k].value} * list[k].value;
    return sum;
  }

  /// Computes the distances of cluster i from all others.
  void findDistances(std::uint32_t i) {
    std::fill(dot_.begin(), dot_.end(), 0.0);
    const Preference* const list = of_.list(i);
    for (std::size_t k = 0; k < of_.length[i]; ++k) {
      const Preference* const others = by_hypothesis_->list(list[k].of);
      const double value = list[k].value;
      for (std::size_t e = 0; e < by_hypothesis_->length[list[k].of]; ++e)
        dot_[others[e].of] += value * others[e].value;
    }
    float* const row = distance_.data() + i * n_;
    for (std::size_t j = 0; j < n_; ++j) {
      const double dot = dot_[j];
      row[j] = dot > 0 ? static_cast<float>(1 - dot / (norm_[i] + norm_[j] - dot)) : 1.0F;
    }
  }

  bool isCloser(std::uint32_t i, std::uint32_t j, std::uint32_t than) const {
    return distance(i, j) < distance(i, than) || (distance(i, j) == distance(i, than) && j < than);
  }

  void findNearest(std::uint32_t i) {
    // The cluster itself stands for none; its distance counts as 1.
    distance_[i * n_ + i] = 1;
    std::uint32_t best = i;
    for (std::uint32_t j = 0; j < n_; ++j) {
      if (size_[j] > 0 && distance(i, j) < distance(i, best)) best = j;
    }
    nearest_[i] = best;
  }

  /// Gives a the preferences that it shares with b, and removes all others of both.
  void intersect(std::uint32_t a, std::uint32_t b) {
    Preference *const list_a = of_.list(a), *const list_b = of_.list(b);
    std::uint32_t kept = 0, k = 0, e = 0;
    while (k < of_.length[a] || e < of_.length[b]) {
      const std::uint32_t of_a = k < of_.length[a] ? list_a[k].of : ~0U;
      const std::uint32_t of_b = e < of_.length[b] ? list_b[e].of : ~0U;
      if (of_a == of_b) {
        const float value = std::min(list_a[k].value, list_b[e].value);
        find(of_a, a)->value = value;
        remove(of_a, b);
        list_a[kept++] = {of_a, value};
        ++k;
        ++e;
      } else if (of_a < of_b) {
        remove(of_a, a);
        ++k;
      } else {
        remove(of_b, b);
        ++e;
      }
    }
    of_.length[a] = kept;
    of_.length[b] = 0;
  }

  Preference* find(std::uint32_t hypothesis, std::uint32_t cluster) {
    Preference* entry = by_hypothesis_->list(hypothesis);
    while (entry->of != cluster) ++entry;
    return entry;
  }

  void remove(std::uint32_t hypothesis, std::uint32_t cluster) {
    *find(hypothesis, cluster) = by_hypothesis_->list(hypothesis)[--by_hypothesis_->length[hypothesis]];
  }

  std::size_t n_ = 0;
  Lists* by_hypothesis_ = nullptr;
  Lists of_;  // by cluster
  std::vector<double> norm_, dot_;
  std::vector<std::uint32_t> size_, parent_, nearest_;  // size 0: merged into another cluster
  std::vector<float> distance_;
};

/// Memory that is kept between calls.
struct TlinkageMemory {
  MatchNeighbours distinct;
  std::vector<std::uint32_t> rows, near, order;
  std::vector<std::uint64_t> keys;
  NormalizedMatches matches;
  std::vector<float> errors;
  Lists preferences;
  Linkage linkage;
  std::vector<std::uint32_t> clusters;
  ClusterNumbers numbers;
};

/// Finds the nearest matches of every match in the space of both points. @return how many of each; 0 where
/// the deadline has passed
std::size_t findNeighbours(const Deadline& deadline, TlinkageMemory& work) {
  const NormalizedMatches& m = work.matches;
  const std::size_t n = m.size(), k = std::min(kNeighbours[kLevels - 1], n - 1);
  work.near.resize(n * k);
  work.keys.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (i % kLook == 0 && deadline.passed()) return 0;
    for (std::size_t j = 0; j < n; ++j) {
      const float dx = m.left_x[j] - m.left_x[i], dy = m.left_y[j] - m.left_y[i];
      const float ex = m.right_x[j] - m.right_x[i], ey = m.right_y[j] - m.right_y[i];
      // The bits of positive numbers have the order of the numbers.
      const float squared = dx * dx + dy * dy + (ex * ex + ey * ey);
      std::uint32_t bits = 0;
      std::memcpy(&bits, &squared, sizeof bits);
      work.keys[j] = std::uint64_t{bits} << 32 | j;
    }
    work.keys[i] = ~std::uint64_t{0};
    const auto end = work.keys.begin() + static_cast<std::ptrdiff_t>(k);
    std::nth_element(work.keys.begin(), end - 1, work.keys.end());
    std::sort(work.keys.begin(), end);
    for (std::size_t e = 0; e < k; ++e) work.near[i * k + e] = static_cast<std::uint32_t>(work.keys[e]);
  }
  return k;
}

std::size_t sampleSize(ModelKind structure) {
  return structure == ModelKind::kFundamental ? kFundamentalSample : kHomographySample;
}

/// Writes the models of a sample. @return their number
int solve(ModelKind structure, const NormalizedMatches& matches, const std::uint32_t* sample,
          cv::Matx33d* models) {
  if (structure == ModelKind::kFundamental) {
    return isValidFundamentalSample(matches, sample) ? fundamentalFromSeven(matches, sample, models) : 0;
  }
  return isValidHomographySample(matches, sample) && homographyFromFour(matches, sample, models[0]) ? 1 : 0;
}

/// Draws models from a match and its neighbours. @return their number; 0 if no sample was valid
int drawModels(ModelKind structure, std::size_t match, std::size_t level, std::size_t listed, Random& random,
               const TlinkageMemory& work, cv::Matx33d* models) {
  const auto pool = static_cast<std::uint32_t>(std::min(kNeighbours[level], listed));
  const std::size_t size = sampleSize(structure);
  for (int draw = 0; draw < kDraws; ++draw) {
    std::uint32_t sample[kFundamentalSample] = {static_cast<std::uint32_t>(match)};
    random.sample(pool, static_cast<std::uint32_t>(size - 1), sample + 1);
    for (std::size_t k = 1; k < size; ++k) sample[k] = work.near[match * listed + sample[k]];
    const int found = solve(structure, work.matches, sample, models);
    if (found > 0) return found;
  }
  return 0;
}

/// Draws the hypotheses and computes the preferences for them. @return false where the deadline has passed
bool findPreferences(const TlinkageOptions& options, const Deadline& deadline, TlinkageMemory& work) {
  const std::size_t n = work.matches.size();
  const std::size_t listed = findNeighbours(deadline, work);
  if (listed == 0) return false;
  Lists& lists = work.preferences;
  lists.entries.clear();
  lists.begin.clear();
  lists.length.clear();
  work.errors.resize(n);
  const Residual residual =
      options.structure == ModelKind::kFundamental ? Residual::kSampson : Residual::kTransfer;
  const bool soft = options.preference == TlinkageOptions::Preference::kSoft;
  const double tau = options.tau * work.matches.scale, reach = (soft ? kReach : 1) * tau;
  const auto squared_reach = static_cast<float>(reach * reach);
  Random random(static_cast<std::uint64_t>(options.seed));
  const std::size_t hypotheses = n * static_cast<std::size_t>(options.hypotheses_per_match);
  work.order.resize(n);
  std::iota(work.order.begin(), work.order.end(), 0U);
  for (std::size_t i = n; i > 1; --i)
    std::swap(work.order[i - 1], work.order[random.index(static_cast<std::uint32_t>(i))]);
  double pairs = 0;
  for (std::size_t k = 0; k < hypotheses && pairs < kMaxPairs; ++k) {
    if (k % kLook == 0 && deadline.passed()) return false;
    cv::Matx33d models[kMaxModels];
    const int found =
        drawModels(options.structure, work.order[k % n], k / n % kLevels, listed, random, work, models);
    for (int model = 0; model < found; ++model) {
      modelErrors(residual, models[model], work.matches, 0, n, work.errors.data());
      lists.begin.push_back(lists.entries.size());
      for (std::uint32_t i = 0; i < n; ++i) {
        if (!(work.errors[i] < squared_reach)) continue;
        const double preference = soft ? std::exp(-std::sqrt(double{work.errors[i]}) / tau) : 1.0;
        lists.entries.push_back({i, static_cast<float>(preference)});
      }
      const std::size_t length = lists.entries.size() - lists.begin.back();
      lists.length.push_back(static_cast<std::uint32_t>(length));
      pairs += static_cast<double>(length) * static_cast<double>(length);
    }
  }
  return true;
}

}  // namespace

void TlinkageOptions::visit(OptionVisitor& visitor) const {
  visitor.choice("structure",
                 {{ModelKind::kHomography, "homography", "Planes"},
                  {ModelKind::kFundamental, "fundamental", "Rigid motions"}},
                 "Model of a cluster", &TlinkageOptions::structure);
  visitor.number({"tau", 0.1, 50, "px", "Scale of the errors of inliers of a model"}, &TlinkageOptions::tau);
  visitor.choice("preference",
                 {{Preference::kSoft, "soft", "Falls with the error: T-Linkage"},
                  {Preference::kHard, "hard", "1 or 0: J-Linkage"}},
                 "Preference of a match for a model", &TlinkageOptions::preference);
  visitor.integer({"min_cluster", 1, 1000000, "-", "Distinct matches of an accepted cluster at least"},
                  &TlinkageOptions::min_cluster);
  visitor.integer({"hypotheses_per_match", 1, 100, "-", "Samples that are drawn, per distinct match"},
                  &TlinkageOptions::hypotheses_per_match);
  visitor.integer({"max_matches", 5, 20000, "-", "More distinct matches than this are too many"},
                  &TlinkageOptions::max_matches);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the sampler"}, &TlinkageOptions::seed);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &TlinkageOptions::max_seconds);
  visitConfidence(visitor);
}

Presets TlinkageSelector::presets() const {
  // Two samples of seven make a cluster, as two of four do by default.
  return {{"jlinkage", {{"preference", "hard"}}},
          {"motions", {{"structure", "fundamental"}, {"tau", "1"}, {"min_cluster", "14"}}}};
}

void TlinkageSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const Deadline deadline(options_.max_seconds);
  TlinkageMemory& work = workspace.part<TlinkageMemory>();
  work.distinct.assign(matches, true);
  const std::size_t n = work.distinct.size();
  const bool fundamental = options_.structure == ModelKind::kFundamental;
  const std::size_t min_matches = sampleSize(options_.structure) + 1;
  if (n < min_matches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " distinct matches, tlinkage needs " + std::to_string(min_matches);
    return;
  }
  if (n > static_cast<std::size_t>(options_.max_matches)) {
    result.status = Status::kTooLarge;
    result.message = std::to_string(n) +
                     " distinct matches, more than max_matches = " + std::to_string(options_.max_matches) +
                     "; preselect matches, or use another selector";
    return;
  }
  work.rows.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) work.rows[i] = work.distinct.rowOf(i);
  normalizeMatches(matches, work.rows, work.matches);
  bool timed_out = !findPreferences(options_, deadline, work);
  if (!timed_out && work.preferences.begin.empty()) {
    result.status = Status::kDegenerate;
    result.message = fundamental ? "no seven neighbouring matches determine a fundamental matrix"
                                 : "no four neighbouring matches determine a homography";
    return;
  }
  timed_out = timed_out || !work.linkage.start(n, work.preferences, deadline);
  while (!timed_out && work.linkage.merge()) {
    ++result.iterations;
    timed_out = deadline.passed();
  }
  if (timed_out) {
    result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
    result.message = "stopped after " + std::to_string(result.iterations) +
                     " mergers, max_seconds = " + formatNumber(options_.max_seconds);
    if (result.iterations == 0) return;
  }
  const std::vector<std::uint32_t>& sizes = work.linkage.sizes();
  work.clusters.resize(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t cluster = work.linkage.clusterOf(i);
    const bool accepted = sizes[cluster] >= static_cast<std::uint32_t>(options_.min_cluster);
    work.clusters[i] = accepted ? cluster : ClusterNumbers::kNone;
  }
  work.numbers.assign(work.clusters, sizes);
  if (work.numbers.count() > 0) result.group.resize(matches.size());
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    const std::uint32_t match = work.distinct.ofRow(i);
    result.score[i] = static_cast<float>(sizes[work.linkage.clusterOf(match)]);
    result.mask[i] = work.clusters[match] != ClusterNumbers::kNone ? 1 : 0;
    if (!result.group.empty()) result.group[i] = work.numbers[work.clusters[match]];
  }
}

}  // namespace corrsel::core
