#include "corrsel/database/cycles.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>

namespace corrsel::core {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kMinNoise = 1e-6, kMaxNoise = 0.3;  // rad; exact rotations do not make it 0
// Scale that the noise is taken to have at least, rad: 0.4 degrees, so that only angles above 3 degrees fail.
constexpr double kInaccurate = 0.007;
constexpr double kMinShare = 1e-3;  // of triplets that are right, and of others
constexpr int kScaleRounds = 50, kRounds = 30;
constexpr double kDamping = 0.5;
constexpr double kMaxSure = 1 - 1e-6;  // of the messages, so that their logarithms are finite
constexpr double kMinPrior = 1e-3, kMaxPrior = 0.4;

/// Three pairs that form a triangle, and the angle by which their rotations do not close, rad.
struct Triplet {
  std::array<std::uint32_t, 3> pairs;
  float angle;
  std::array<float, 3> message;  // to each pair: log of the ratio of the evidences for right and wrong
};

std::string pairText(const ImagePairKey& pair) {
  return "(" + std::to_string(pair.first) + ", " + std::to_string(pair.second) + ")";
}

/// Angle of a rotation, rad. Exact also near 0, where the trace alone is not.
double angleOf(const cv::Matx33d& r) {
  const double x = r(2, 1) - r(1, 2), y = r(0, 2) - r(2, 0), z = r(1, 0) - r(0, 1);
  return std::atan2(std::sqrt(x * x + y * y + z * z), cv::trace(r) - 1);
}

void check(const std::vector<RelativeRotation>& rotations, int max_triplets) {
  constexpr double kTolerance = 1e-6;
  if (max_triplets < 1)
    throw std::invalid_argument("cycles: max_triplets is " + std::to_string(max_triplets) +
                                "; it is at least 1");
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const RelativeRotation& r = rotations[i];
    if (!(r.pair.first < r.pair.second))
      throw std::invalid_argument("cycles: the pair of images " + pairText(r.pair) +
                                  " does not name two images, the smaller number first");
    if (i > 0 && rotations[i - 1].pair == r.pair)
      throw std::invalid_argument("cycles: the pair of images " + pairText(r.pair) +
                                  " is listed twice; list every pair once");
    const double off = cv::norm(r.rotation * r.rotation.t() - cv::Matx33d::eye());
    if (!(off <= kTolerance) || !(cv::determinant(r.rotation) > 0))
      throw std::invalid_argument("cycles: the matrix of the pair of images " + pairText(r.pair) +
                                  " is no rotation (|R R^T - I| is " + std::to_string(off) + ")");
  }
}

/// The triplets of images of which all three pairs are there.
class TripletSearch {
 public:
  /// @param rotations  in ascending order of the pairs
  explicit TripletSearch(const std::vector<RelativeRotation>& rotations) : rotations_(rotations) {
    for (std::uint32_t i = 0; i < rotations.size(); ++i) {
      neighbours_[rotations[i].pair.first].emplace_back(rotations[i].pair.second, i);
      neighbours_[rotations[i].pair.second].emplace_back(rotations[i].pair.first, i);
    }
    for (auto& [image, list] : neighbours_) std::sort(list.begin(), list.end());
  }

  /// All of them, or of each pair about max_triplets, which are evenly many over the third images.
  std::vector<Triplet> find(std::size_t max_triplets) {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (std::uint32_t pair = 0; pair < rotations_.size(); ++pair) {
      findThird(pair);
      const std::size_t step_count = std::min(max_triplets, third_.size());
      for (std::size_t k = 0; k < step_count; ++k) {
        const auto& [a, b] = third_[k * third_.size() / step_count];
        std::array<std::uint32_t, 3> triangle = {pair, a, b};
        std::sort(triangle.begin(), triangle.end());
        triangles.push_back(triangle);
      }
    }
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    std::vector<Triplet> triplets;
    triplets.reserve(triangles.size());
    for (const auto& pairs : triangles) triplets.push_back({pairs, closingAngle(pairs), {}});
    return triplets;
  }

 private:
  /// Writes the pairs that connect both images of a pair with each of their common neighbours.
  void findThird(std::uint32_t pair) {
    third_.clear();
    const auto& a = neighbours_[rotations_[pair].pair.first];
    const auto& b = neighbours_[rotations_[pair].pair.second];
    for (std::size_t i = 0, k = 0; i < a.size() && k < b.size();) {
      if (a[i].first == b[k].first)
        third_.emplace_back(a[i++].second, b[k++].second);
      else if (a[i].first < b[k].first)
        ++i;
      else
        ++k;
    }
  }

  /// Of the pairs (i, j), (i, k), (j, k) with i < j < k, which is their ascending order.
  float closingAngle(const std::array<std::uint32_t, 3>& pairs) const {
    return static_cast<float>(angleOf(rotations_[pairs[1]].rotation.t() * rotations_[pairs[2]].rotation *
                                      rotations_[pairs[0]].rotation));
  }

  const std::vector<RelativeRotation>& rotations_;
  std::map<std::uint32_t, std::vector<std::pair<std::uint32_t, std::uint32_t>>> neighbours_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> third_;
};

/// The distributions of the angles of triplets that are right, and of others.
class AngleModel {
 public:
  /// Estimates scale and share of the triplets that are right.
  void fit(const std::vector<Triplet>& triplets) {
    std::vector<float> angles;
    angles.reserve(triplets.size());
    for (const Triplet& t : triplets) angles.push_back(t.angle);
    const auto quartile = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 4);
    std::nth_element(angles.begin(), quartile, angles.end());
    constexpr double kQuartile = 1.1;  // of the length of three standard normal coordinates
    noise_ = std::max(kMinNoise, *quartile / kQuartile);
    for (int round = 0; round < kScaleRounds; ++round) update(angles);
  }

  /// Ratio of the densities for other triplets and for those that are right.
  double ratio(double angle) const {
    // Both begin with the square of the angle, which cancels: the ratio is finite at 0.
    const double s = scale(), x = angle / s;
    const double other = (x < 1 ? 1 : 1 / (x * x)) / (kPi - s * 2 / 3);
    return other * s / (kNorm * std::pow(1 + x * x / kFreedom, -kExponent));
  }

  /// The scale of the noise, rad.
  double noise() const { return noise_; }
  double share() const { return share_; }

  /// The angle from which on the density for other triplets is the larger one.
  double threshold() const {
    double low = std::sqrt(1.6) * scale(), high = kPi;  // the ratio is lowest at `low` and rises from there
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (ratio(middle) > 1 ? high : low) = middle;
    }
    return high;
  }

 private:
  // Of Student's distribution in three dimensions with 4 degrees of freedom, for the length in units of the
  // scale: (15 / 16) x^2 (1 + x^2 / 4)^(-7 / 2).
  static constexpr double kFreedom = 4, kNorm = 15.0 / 16, kExponent = 3.5;

  /// A step of the EM algorithm.
  void update(const std::vector<float>& angles) {
    double right = 0, squares = 0;
    for (const double angle : angles) {
      const double odds = share_ / ((1 - share_) * ratio(angle));
      const double probability = odds / (1 + odds);
      const double x = angle / noise_;
      right += probability;
      squares += probability * (kFreedom + 3) / (kFreedom + x * x) * angle * angle;
    }
    if (!(right > 0)) return;
    noise_ = std::clamp(std::sqrt(squares / (3 * right)), kMinNoise, kMaxNoise);
    share_ = std::clamp(right / static_cast<double>(angles.size()), kMinShare, 1 - kMinShare);
  }

  double scale() const { return std::max(noise_, kInaccurate); }

  double noise_ = kMinNoise, share_ = 0.5;
};

/// Finds the probability that each pair is wrong from the triplets.
class Beliefs {
 public:
  Beliefs(std::size_t pairs, std::vector<Triplet>& triplets, const AngleModel& model)
      : triplets_(triplets), log_odds_(pairs), ratios_(triplets.size()) {
    for (std::size_t i = 0; i < triplets.size(); ++i)
      ratios_[i] = static_cast<float>(model.ratio(triplets[i].angle));
    // Three right pairs make a right triplet.
    prior_ = std::clamp(1 - std::cbrt(model.share()), kMinPrior, kMaxPrior);
    for (int round = 0; round < kRounds; ++round) {
      addMessages();
      sendMessages();
    }
    addMessages();
  }

  double wrong(std::size_t pair) const { return 1 / (1 + std::exp(log_odds_[pair])); }

 private:
  void addMessages() {
    std::fill(log_odds_.begin(), log_odds_.end(), std::log((1 - prior_) / prior_));
    for (const Triplet& t : triplets_)
      for (int k = 0; k < 3; ++k) log_odds_[t.pairs[k]] += t.message[k];
  }

  void sendMessages() {
    for (std::size_t i = 0; i < triplets_.size(); ++i) {
      Triplet& t = triplets_[i];
      std::array<double, 3> right;
      for (int k = 0; k < 3; ++k) right[k] = 1 / (1 + std::exp(t.message[k] - log_odds_[t.pairs[k]]));
      for (int k = 0; k < 3; ++k) {
        const double others = std::min(right[(k + 1) % 3] * right[(k + 2) % 3], kMaxSure);
        const double message = std::log(others / ratios_[i] + 1 - others);
        t.message[k] = static_cast<float>(kDamping * t.message[k] + (1 - kDamping) * message);
      }
    }
  }

  std::vector<Triplet>& triplets_;
  std::vector<double> log_odds_;  // by pair, of being right
  std::vector<float> ratios_;     // by triplet
  double prior_;
};

void count(const std::vector<Triplet>& triplets, CycleReport& report) {
  for (const Triplet& t : triplets) {
    const bool fails = t.angle > report.threshold;
    for (const std::uint32_t pair : t.pairs)
      ++(fails ? report.pairs[pair].failing : report.pairs[pair].closing);
    report.failing += fails ? 1 : 0;
  }
  report.triplets = triplets.size();
}

}  // namespace

std::optional<RelativeRotation> relativeRotation(const VerifiedPair& pair) {
  if (pair.faulty || !pair.geometry.pose) return std::nullopt;
  return RelativeRotation{pair.pair, pair.geometry.pose->rotation};
}

CycleReport checkCycles(std::vector<RelativeRotation> rotations, int max_triplets) {
  std::sort(rotations.begin(), rotations.end(),
            [](const RelativeRotation& a, const RelativeRotation& b) { return a.pair < b.pair; });
  check(rotations, max_triplets);
  CycleReport report;
  for (const RelativeRotation& r : rotations) report.pairs.push_back({r.pair, 0, 0, 0, false});
  std::vector<Triplet> triplets = TripletSearch(rotations).find(static_cast<std::size_t>(max_triplets));
  report.unchecked = rotations.size();
  if (triplets.empty()) return report;
  AngleModel model;
  model.fit(triplets);
  report.noise = model.noise();
  report.threshold = model.threshold();
  count(triplets, report);
  const Beliefs beliefs(rotations.size(), triplets, model);
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    PairCycles& pair = report.pairs[i];
    report.unchecked -= pair.closing + pair.failing > 0 ? 1 : 0;
    pair.wrong = beliefs.wrong(i);
    pair.accused = pair.failing > 0 && pair.wrong > 0.5;
    report.accused += pair.accused ? 1 : 0;
  }
  return report;
}

}  // namespace corrsel::core
