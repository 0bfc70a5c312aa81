#include "corrsel/reference/rrwm.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "base/deadline.h"
#include "points/point_groups.h"
#include "selectors/parts/otsu.h"
#include "selectors/parts/pair_matrix.h"

namespace corrsel::core {
namespace {

using Vector = Eigen::VectorXd;

// Steps of the walk, the squared change at which they end, the same for the normalisation of the jumps, and
// the grid on which points are equal, px.
constexpr int kMaxSteps = 100, kMaxNormalisations = 1000;
constexpr double kMinChange = 1e-20, kMinJumpChange = 1e-6, kSamePoint = 1.0 / 64;
constexpr int kOtsuBins = 256;
// Values that differ by less, relative to the largest, differ by rounding only.
constexpr double kEqualValues = 1e-4;

/// Reweighted random walks on the affinities. Equal matches are one row with a multiplicity; they share their
/// points, so that they have no affinity.
class ReweightedWalk {
 public:
  ReweightedWalk(PairMemory& space, const RrwmOptions& options, const Deadline& deadline)
      : space_(space), options_(options), deadline_(deadline) {
    const auto n = static_cast<Eigen::Index>(space.distinct.size());
    const PairColumns m = space.distinct.columns();
    count_.resize(n);
    for (Eigen::Index i = 0; i < n; ++i)
      count_[i] = static_cast<double>(space.distinct.multiplicity(static_cast<std::size_t>(i)));
    left_.number({m.left_x, m.left_x + n}, {m.left_y, m.left_y + n}, kSamePoint);
    right_.number({m.right_x, m.right_x + n}, {m.right_y, m.right_y + n}, kSamePoint);
  }

  /// The distribution of the walk, largest entry 1; all zero where the matrix is zero; the best so far where
  /// time ran out.
  Vector compute() {
    const double total = count_.sum();
    Vector q = Vector::Constant(count_.size(), 1 / total), jump = q, before = q, before_that = q, next;
    while (products_ < kMaxSteps) {
      next.resize(q.size());
      scaled_ = count_.cwiseProduct((1 - options_.jump) * q + options_.jump * jump);
      timed_out_ = !space_.matrix.multiply(scaled_.data(), next.data(), deadline_, options_.threads);
      if (timed_out_) break;
      mean_affinity_ = next.dot(scaled_) / (1 - scaled_.dot(scaled_.cwiseQuotient(count_)));
      ++products_;
      const double sum = next.dot(count_);
      if (sum <= 0) return Vector::Zero(q.size());
      next = next.cwiseMax(0) / sum;
      const double change = std::min(squaredDistance(next, before), squaredDistance(next, before_that));
      before_that = before;
      before = q = next;
      if (change < kMinChange) break;
      jump = jumps(q);
    }
    if (products_ == 0) return Vector::Zero(q.size());
    return q / q.maxCoeff();
  }

  int products() const { return products_; }
  bool timedOut() const { return timed_out_; }
  double meanAffinity() const { return mean_affinity_; }

 private:
  double squaredDistance(const Vector& a, const Vector& b) const {
    return (a - b).cwiseProduct(count_).dot(a - b);
  }

  /// Divides every entry by the sum over its group.
  void normalise(const PointGroups& groups, Vector& a) {
    sums_.assign(groups.sizes.size(), 0.0);
    for (Eigen::Index i = 0; i < a.size(); ++i)
      sums_[groups.of[static_cast<std::size_t>(i)]] += a[i] * count_[i];
    for (Eigen::Index i = 0; i < a.size(); ++i) a[i] /= sums_[groups.of[static_cast<std::size_t>(i)]];
  }

  Vector jumps(const Vector& q) {
    Vector a = (options_.inflation / q.maxCoeff() * q).array().exp(), before;
    for (int k = 0; k < kMaxNormalisations; ++k) {
      before = a;
      normalise(left_, a);
      normalise(right_, a);
      if (squaredDistance(a, before) < kMinJumpChange) break;
    }
    return a / a.dot(count_);
  }

  PairMemory& space_;
  const RrwmOptions& options_;
  const Deadline& deadline_;
  PointGroups left_, right_;
  Vector count_, scaled_;
  std::vector<double> sums_;
  int products_ = 0;
  double mean_affinity_ = 0;
  bool timed_out_ = false;
};

/// Selects the matches above Otsu's threshold; all or none of them where their values are equal.
void selectByOtsu(const Vector& v, bool all_if_equal, const DistinctMatches& distinct, Selection& result) {
  if (v.maxCoeff() == 0) return;
  double threshold = all_if_equal ? 0 : 1;
  if (v.minCoeff() < 1 - kEqualValues) {
    std::vector<double> values;
    values.reserve(result.mask.size());
    for (std::size_t i = 0; i < result.mask.size(); ++i) values.push_back(v[distinct.ofRow(i)]);
    threshold = otsuThreshold(values, v.minCoeff(), 1, kOtsuBins).value_or(0);
  }
  for (std::size_t i = 0; i < result.mask.size(); ++i)
    result.mask[i] = v[distinct.ofRow(i)] > threshold ? 1 : 0;
}

}  // namespace

void RrwmOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"threshold", 0, 1, "-",
                  "Mean affinity above which all matches are selected where the walk tells none apart"},
                 &RrwmOptions::threshold);
  visitor.number({"jump", 0, 1, "-", "Share of the reweighting jumps"}, &RrwmOptions::jump);
  visitor.number({"inflation", 0, 100, "-", "Exponent of the jumps"}, &RrwmOptions::inflation);
  visitor.integer(
      {"memory_limit", 0, 1 << 20, "MiB",
       "Affinities that need more than this are computed again in every step, with the same result"},
      &RrwmOptions::memory_limit);
  visitor.integer({"threads", 1, 1024, "-", "Threads for large inputs; results do not depend on it"},
                  &RrwmOptions::threads);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &RrwmOptions::max_seconds);
  visitConfidence(visitor);
}

void RrwmSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  if (matches.empty()) return;
  const Deadline deadline(options_.max_seconds);
  PairMemory& space = workspace.part<PairMemory>();
  PairRule rule;
  rule.one_to_one = true;
  space.assign(matches, PairValue::kRatio, rule, options_.memory_limit);
  ReweightedWalk walk(space, options_, deadline);
  const Vector v = walk.compute();
  result.iterations = walk.products();
  space.matrix.release();
  if (!writeScores(space.distinct, v.data(), walk.timedOut(), options_.max_seconds, result)) return;
  selectByOtsu(v, walk.meanAffinity() > options_.threshold, space.distinct, result);
}

}  // namespace corrsel::core
