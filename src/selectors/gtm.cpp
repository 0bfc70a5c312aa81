#include "corrsel/selectors/gtm.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/text.h"
#include "geometry/frame_map.h"
#include "selectors/parts/degenerate_input.h"
#include "selectors/parts/otsu.h"
#include "selectors/parts/pair_matrix.h"

namespace corrsel::core {
namespace {

using Vector = Eigen::VectorXd;

constexpr double kTolerance = 1e-6;  // replicator: of payoffs in a step, relative to their mean
constexpr int kOtsuBins = 256;
// Populations that differ by less per step, relative to the largest, differ by rounding only: sums of 256
// equal terms in single precision can be that far off.
constexpr double kEqualPopulations = 1e-5;
// Where all populations are equal, all matches are selected if they err by less than 1 / lambda.
const double kMinPayoff = std::exp(-1.0);
constexpr double kReferenceDiagonal = 1000;  // px, for normalize_lambda
constexpr double kReferenceMatches = 1000;   // equilibrium: lambda is meant for as many
constexpr Eigen::Index kSeeds = 1000;        // equilibrium: matches of the first population
constexpr double kNashTolerance =
    1e-3;                           // equilibrium: gain left, relative to mean payoff * (1 - mean payoff)
constexpr int kMaxSteps = 1000000;  // equilibrium

/// A population: how many play each of the distinct matches, and what they are paid.
struct Population {
  Vector share;  // sum over all matches is 1
  double mean_payoff = 0;
  int steps = 0;
  bool timed_out = false;
};

constexpr std::size_t kBasis = 32;  // vectors whose products are kept

/// Memory of the products that is kept between calls.
struct ProductMemory {
  std::vector<Vector> basis = std::vector<Vector>(kBasis), product = std::vector<Vector>(kBasis);
};

/// Products P x of vectors x that follow one another smoothly. P is linear: of the part of x that lies in the
/// span of vectors whose products are known, the product is known too. What is left of x is multiplied and
/// joins them, or is dropped where its sum of absolute values, the most that payoffs <= 1 can make of it, is
/// below a tolerance.
class SmoothProducts {
 public:
  SmoothProducts(PairMatrix& matrix, ProductMemory& memory, const Vector& diagonal, int threads,
                 const Deadline& deadline)
      : matrix_(matrix), memory_(memory), diagonal_(diagonal), threads_(threads), deadline_(deadline) {}

  /// y = P x + diagonal * x, elements to `tolerance`. @return false where the deadline passed.
  bool multiply(const Vector& x, double tolerance, Vector& y) {
    std::vector<Vector>&basis = memory_.basis, &product = memory_.product;
    y.setZero(x.size());
    rest_ = x;
    // The second time for what rounding left over.
    for (int pass = 0; pass < 2; ++pass) {
      for (std::size_t k = 0; k < size_; ++k) {
        const double component = basis[k].dot(rest_);
        rest_ -= component * basis[k];
        y += component * product[k];
      }
      if (rest_.lpNorm<1>() <= tolerance) return true;
    }
    size_ = std::min(size_ + 1, kBasis);
    Vector &direction = basis[size_ - 1], &image = product[size_ - 1];
    const double length = rest_.norm();
    direction = rest_ / length;
    image.resize(x.size());
    if (!matrix_.multiply(direction.data(), image.data(), deadline_, threads_)) return false;
    image += diagonal_.cwiseProduct(direction);
    y += length * image;
    return true;
  }

 private:
  PairMatrix& matrix_;
  ProductMemory& memory_;
  const Vector& diagonal_;
  const int threads_;
  const Deadline& deadline_;
  Vector rest_;
  std::size_t size_ = 0;
};

class Game {
 public:
  Game(Workspace& workspace, const PairRule& rule, const GtmOptions& options, const Deadline& deadline)
      : space_(workspace.part<PairMemory>()),
        memory_(workspace.part<ProductMemory>()),
        rule_(rule),
        options_(options),
        deadline_(deadline) {
    diagonal_.resize(static_cast<Eigen::Index>(space_.distinct.size()));
    // Players of a repeated match meet others of their kind, but not themselves.
    for (Eigen::Index i = 0; i < count(); ++i)
      diagonal_[i] = options.one_to_one ? 0 : (multiplicity(i) - 1) / multiplicity(i);
  }

  /// Discrete replicator dynamics from the uniform population (the paper's Eq. 9).
  Population replicator() {
    Population population;
    Vector& share = population.share;
    share.resize(count());
    for (Eigen::Index i = 0; i < count(); ++i) share[i] = multiplicity(i);
    share /= share.sum();
    space_.matrix.assign(PairValue::kPayoff, rule_, space_.distinct.columns(), space_.distinct.size(),
                         static_cast<std::size_t>(options_.memory_limit) << 20);
    SmoothProducts products(space_.matrix, memory_, diagonal_, options_.threads, deadline_);
    Vector payoff;
    for (; population.steps < options_.steps; ++population.steps) {
      population.timed_out =
          deadline_.passed() || !products.multiply(share, kTolerance * population.mean_payoff, payoff);
      if (population.timed_out) break;
      population.mean_payoff = share.dot(payoff);
      if (population.mean_payoff == 0) break;
      share = share.cwiseProduct(payoff).cwiseMax(0);
      share /= share.sum();
    }
    space_.matrix.release();
    return population;
  }

  /// Infection and immunization dynamics (Rota Bulo and Bomze, Games and Economic Behavior 2011).
  Population equilibrium() {
    Population population;
    Vector& share = population.share;
    share.setZero(count());
    Vector payoff = Vector::Zero(count()), row(count());
    // Any spread-out population will do to start from.
    const Eigen::Index stride = (count() + kSeeds - 1) / kSeeds;
    const double seeds = static_cast<double>((count() + stride - 1) / stride);
    for (Eigen::Index i = 0; i < count(); i += stride) {
      population.timed_out = deadline_.passed();
      if (population.timed_out) return population;
      share[i] = 1 / seeds;
      computeRow(i, row);
      payoff += share[i] * row;
    }
    for (; population.steps < kMaxSteps; ++population.steps) {
      const double mean = population.mean_payoff = share.dot(payoff);
      // The strategy that the population gains most by taking up or by giving up.
      Eigen::Index best = 0;
      const double gain =
          (share.array() > 0).select((payoff.array() - mean).abs(), payoff.array() - mean).maxCoeff(&best);
      if (gain <= kNashTolerance * mean * (1 - mean)) break;
      population.timed_out = deadline_.passed();
      if (population.timed_out) break;
      computeRow(best, row);
      // The best point on the line through the vertex `best`, as far as no share falls below zero.
      const double slope = payoff[best] - mean, curvature = row[best] - 2 * payoff[best] + mean;
      const double farthest = slope > 0 ? 1 : -share[best] / (1 - share[best]);
      const double wanted = curvature < 0 ? -slope / curvature : farthest;
      const bool to_the_end = std::abs(wanted) >= std::abs(farthest);
      const double step = to_the_end ? farthest : wanted;
      share *= 1 - step;
      share[best] = to_the_end ? std::max(step, 0.0) : share[best] + step;
      payoff += step * (row - payoff);
    }
    return population;
  }

 private:
  Eigen::Index count() const { return diagonal_.size(); }
  double multiplicity(Eigen::Index i) const {
    return static_cast<double>(space_.distinct.multiplicity(static_cast<std::size_t>(i)));
  }

  void computeRow(Eigen::Index i, Vector& row) {
    const PairColumns columns = space_.distinct.columns();
    row_.resize(columns.size);
    kernels().pairs.payoff_row(columns, rule_, static_cast<std::size_t>(i), columns.size, row_.data());
    row = Eigen::Map<const Eigen::VectorXf>(row_.data(), row.size()).cast<double>();
    row[i] = diagonal_[i];
  }

  PairMemory& space_;
  ProductMemory& memory_;
  PairRule rule_;
  const GtmOptions& options_;
  const Deadline& deadline_;
  Vector diagonal_;
  std::vector<float> row_;
};

/// Writes the score of each match, its share of the population relative to the largest, and selects by it.
void writeSelection(const GtmOptions& options, const std::vector<std::uint32_t>& rows,
                    const DistinctMatches& distinct, const Population& population, Selection& result) {
  const bool replicator = options.dynamics == GtmOptions::Dynamics::kReplicator;
  Vector value = population.share;
  double sum_of_squares = 0;
  for (std::size_t i = 0; i < distinct.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double count = static_cast<double>(distinct.multiplicity(i));
    // At an equilibrium of a one-to-one game equal matches share what one of them would have.
    if (replicator || !options.one_to_one) value[k] /= count;
    sum_of_squares += population.share[k] * population.share[k] / count;
  }
  value /= value.maxCoeff();
  double threshold = options.min_share;
  if (replicator && value.minCoeff() >= 1 - kEqualPopulations * population.steps) {
    threshold = population.mean_payoff > kMinPayoff * (1 - sum_of_squares) ? 0 : 1;
    if (result.message.empty()) result.message = "no match stands out";
  } else if (replicator) {
    std::vector<double> values;
    values.reserve(rows.size());
    for (const std::uint32_t row : rows) values.push_back(value[distinct.ofRow(row)]);
    threshold = otsuThreshold(values, value.minCoeff(), 1, kOtsuBins).value_or(0);
  }
  result.score.assign(result.mask.size(), std::numeric_limits<float>::quiet_NaN());
  for (const std::uint32_t row : rows) {
    const double v = value[distinct.ofRow(row)];
    result.score[row] = static_cast<float>(v);
    result.mask[row] = v > threshold ? 1 : 0;
  }
}

}  // namespace

void GtmOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"lambda", 0, 1, "1/px", "Payoff of two matches = exp(-lambda * error)"},
                 &GtmOptions::lambda);
  visitor.flag("normalize_lambda",
               "Lambda is meant for right images with a diagonal of 1000 px and scaled for others",
               &GtmOptions::normalize_lambda);
  visitor.choice("dynamics",
                 {{Dynamics::kReplicator, "replicator", "Replicator steps, threshold by Otsu"},
                  {Dynamics::kEquilibrium, "equilibrium", "Equilibrium by infection and immunization"}},
                 "A number of replicator steps, or the equilibrium of the game", &GtmOptions::dynamics);
  visitor.integer({"steps", 1, 100000, "-", "Replicator: steps"}, &GtmOptions::steps);
  visitor.number({"min_share", 0, 1, "-",
                  "Equilibrium: matches above this share of the largest population are selected"},
                 &GtmOptions::min_share);
  visitor.flag("one_to_one", "Matches that share a point in one of the images pay nothing to each other",
               &GtmOptions::one_to_one);
  visitor.integer({"memory_limit", 0, 1 << 20, "MiB",
                   "Payoffs that need more than this are computed again in every step, with the same result"},
                  &GtmOptions::memory_limit);
  visitor.integer(
      {"threads", 1, 1024, "-", "Replicator: threads for large inputs; results do not depend on it"},
      &GtmOptions::threads);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &GtmOptions::max_seconds);
  visitConfidence(visitor);
}

Presets GtmSelector::presets() const {
  return {{"paper", {}}, {"equilibrium", {{"dynamics", "equilibrium"}, {"lambda", "2e-05"}}}};
}

std::string GtmSelector::missingInput(const Correspondences& matches) const {
  if (matches.empty()) return "";
  const std::string frames = missingFrames(matches, "gtm");
  if (!frames.empty()) return frames;
  if (options_.normalize_lambda && (matches.right_size.width <= 0 || matches.right_size.height <= 0))
    return "gtm needs the size of the right image";
  return "";
}

void GtmSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  const Deadline deadline(options_.max_seconds);
  std::vector<std::uint32_t> rows;
  std::vector<LinearMap> maps;
  findFrameMaps(matches, maps, rows);
  if (rows.empty()) {
    result.status = Status::kDegenerate;
    result.message = "no match has usable frames";
    return;
  }
  if (rows.size() < n) result.message = std::to_string(n - rows.size()) + " matches have no usable frames";
  PairMemory& space = workspace.part<PairMemory>();
  space.distinct.assign(matches, maps, rows);
  double lambda = options_.lambda;
  if (options_.normalize_lambda)
    lambda *= kReferenceDiagonal / std::hypot(matches.right_size.width, matches.right_size.height);
  const bool replicator = options_.dynamics == GtmOptions::Dynamics::kReplicator;
  // What an equilibrium tolerates shrinks with the number of its members.
  if (!replicator) lambda *= kReferenceMatches / static_cast<double>(space.distinct.size());
  PairRule rule;
  rule.scale = static_cast<float>(lambda / std::log(2.0));
  rule.one_to_one = options_.one_to_one;
  Game game(workspace, rule, options_, deadline);
  const Population population = replicator ? game.replicator() : game.equilibrium();
  result.iterations = population.steps;
  if (population.timed_out) {
    result.status = population.steps == 0 ? Status::kTooLarge : Status::kTimeLimit;
    result.message = "stopped after " + std::to_string(population.steps) +
                     " steps, max_seconds = " + formatNumber(options_.max_seconds);
    if (population.steps == 0) return;
  }
  if (space.distinct.size() == 1 && rows.size() > 1) {
    result.status = Status::kDegenerate;
    result.message = "all matches are equal";
  }
  if (population.mean_payoff == 0) {
    if (result.message.empty()) result.message = "no two matches agree";
    return;
  }
  writeSelection(options_, rows, space.distinct, population, result);
}

}  // namespace corrsel::core
