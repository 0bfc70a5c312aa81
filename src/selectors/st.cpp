#include "corrsel/selectors/st.h"

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "points/point_groups.h"
#include "selectors/parts/pair_matrix.h"

namespace corrsel::core {
namespace {

using Vector = Eigen::VectorXd;

constexpr double kTolerance = 1e-6;  // of the residual, relative to the eigenvalue
constexpr double kZero = 1e-5;       // smaller entries, relative to the largest, are zero
constexpr int kBasis = 16;           // Lanczos vectors before a restart
constexpr int kMaxProducts = 1000;

/// Matrix of at most kBasis rows, without heap memory.
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kBasis, kBasis>;
using SmallVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kBasis, 1>;

/// Memory of the Lanczos processes that is kept between calls.
struct LanczosMemory {
  std::vector<Vector> basis = std::vector<Vector>(kBasis);
  Vector image;
};

/// The principal eigenvector of the affinities by Lanczos processes. Equal matches are one row: with
/// multiplicities w, u_i = sqrt(w_i) v_i is the eigenvector of the symmetric matrix B of sqrt(w_i w_j) a_ij
/// with the diagonal (w_i - 1) * duplicate_affinity.
class PrincipalEigenvector {
 public:
  PrincipalEigenvector(PairMemory& space, LanczosMemory& memory, double duplicate_affinity, int threads,
                       const Deadline& deadline)
      : space_(space),
        memory_(memory),
        duplicate_affinity_(duplicate_affinity),
        threads_(threads),
        deadline_(deadline) {
    root_weight_.resize(static_cast<Eigen::Index>(space.distinct.size()));
    for (std::size_t i = 0; i < space.distinct.size(); ++i)
      root_weight_[static_cast<Eigen::Index>(i)] = std::sqrt(double(space.distinct.multiplicity(i)));
  }

  /// The non-negative eigenvector, largest entry 1; all zero where the matrix is zero; the best so far where
  /// time ran out.
  Vector compute() {
    Vector u = root_weight_.normalized();
    while (!improve(u)) {
    }
    if (products_ == 0) return Vector::Zero(u.size());
    u = (degree_.array() > 0).select(u.cwiseMax(0).cwiseQuotient(root_weight_), 0);
    const double largest = u.maxCoeff();
    return (u.array() > kZero * largest).select(u / largest, 0);
  }

  int products() const { return products_; }
  bool timedOut() const { return timed_out_; }

 private:
  /// image = B u
  bool multiply(const Vector& u, Vector& image) {
    scaled_ = root_weight_.cwiseProduct(u);
    image.resize(u.size());
    timed_out_ = !space_.matrix.multiply(scaled_.data(), image.data(), deadline_, threads_);
    if (timed_out_) return false;
    image = image.cwiseProduct(root_weight_) +
            duplicate_affinity_ * (root_weight_.array().square() - 1).matrix().cwiseProduct(u);
    if (products_ == 0) {
      degree_ = image;
      // The greedy step takes about as long as the first product, at most.
      deadline_.reserve(deadline_.elapsed());
    }
    ++products_;
    return true;
  }

  /// One Lanczos process from u, which becomes the best vector of its basis. @return true when it is final.
  bool improve(Vector& u) {
    std::vector<Vector>& basis = memory_.basis;
    Vector& image = memory_.image;
    SmallMatrix projected = SmallMatrix::Zero(kBasis, kBasis);
    SmallVector weights = SmallVector::Ones(1);
    basis[0] = u;
    bool final = false;
    for (int k = 0; k < kBasis && !final; ++k) {
      if (!multiply(basis[std::size_t(k)], image)) {
        final = true;
        break;
      }
      projected(k, k) = basis[std::size_t(k)].dot(image);
      // Against all, since rounding would let found directions come back; twice is enough (Kahan).
      for (int pass = 0; pass < 2; ++pass) {
        for (int j = 0; j <= k; ++j) image -= basis[std::size_t(j)].dot(image) * basis[std::size_t(j)];
      }
      const double rest = image.norm();
      const Eigen::SelfAdjointEigenSolver<SmallMatrix> solver(projected.topLeftCorner(k + 1, k + 1));
      weights = solver.eigenvectors().col(k);
      final =
          rest * std::abs(weights(k)) <= kTolerance * solver.eigenvalues()(k) || products_ >= kMaxProducts;
      if (final || k + 1 == kBasis) break;
      projected(k, k + 1) = projected(k + 1, k) = rest;
      basis[std::size_t(k) + 1] = image / rest;
    }
    u.setZero();
    for (int k = 0; k < weights.size(); ++k) u += weights(k) * basis[std::size_t(k)];
    // The sign is free; with non-negative affinities all entries agree in it.
    u *= (u.sum() < 0 ? -1 : 1) / u.norm();
    return final;
  }

  PairMemory& space_;
  LanczosMemory& memory_;
  double duplicate_affinity_;
  int threads_;
  Deadline deadline_;
  Vector root_weight_, scaled_, degree_;
  int products_ = 0;
  bool timed_out_ = false;
};

/// The distinct matches that the greedy step selects. A block of matches is decided first; then those that it
/// selects drop what is in conflict with them behind the block, side by side in stretches of columns.
std::vector<std::uint8_t> withoutConflicts(const Vector& v, PairValue value, const PairRule& rule,
                                           int threads, DistinctMatches& distinct) {
  constexpr std::size_t kBlock = 256, kStretch = 1024;
  static_assert(kBlock % PairBlock::kColumns == 0 && kStretch % PairBlock::kColumns == 0, "whole blocks");
  std::vector<std::uint32_t> order;
  for (std::uint32_t i = 0; i < v.size(); ++i) {
    if (v[i] > 0) order.push_back(i);
  }
  std::sort(order.begin(), order.end(),
            [&v](std::uint32_t a, std::uint32_t b) { return v[a] != v[b] ? v[a] > v[b] : a < b; });
  const PairColumns columns = distinct.columns(order);
  const auto drop = kernels().pairs.conflicts[static_cast<std::size_t>(value)];
  std::vector<std::int32_t> alive(columns.size, -1);
  std::vector<std::uint8_t> selected(distinct.size(), 0);
  std::vector<std::size_t> of_block;
  for (std::size_t begin = 0; begin < order.size(); begin += kBlock) {
    const std::size_t end = std::min(begin + kBlock, columns.size);
    of_block.clear();
    for (std::size_t k = begin; k < std::min(end, order.size()); ++k) {
      if (alive[k] == 0) continue;
      selected[order[k]] = 1;
      of_block.push_back(k);
      drop(columns, rule, k, k / PairBlock::kColumns * PairBlock::kColumns, end, alive.data());
    }
    forEachBlock(columns.size - end, kStretch, threads, [&](std::size_t first, std::size_t last) {
      for (const std::size_t k : of_block) drop(columns, rule, k, end + first, end + last, alive.data());
    });
  }
  return selected;
}

PairRule ruleOf(const StOptions& options) {
  PairRule rule;
  rule.scale = static_cast<float>(1 / (9 * options.sigma * options.sigma));
  rule.one_to_one = options.one_to_one;
  rule.threshold = static_cast<float>(options.threshold);
  rule.squared_threshold =
      static_cast<float>(options.threshold < 0 ? -1 : options.threshold * options.threshold);
  rule.noise_floor = static_cast<float>(options.noise_floor);
  return rule;
}

}  // namespace

void StOptions::visit(OptionVisitor& visitor) const {
  visitor.choice(
      "affinity",
      {{Affinity::kRatio, "ratio", "Smaller distance / larger distance"},
       {Affinity::kDifference, "difference", "Falls with the squared difference of the distances"}},
      "Affinity of two matches: ratio or difference of their distances in the two images",
      &StOptions::affinity);
  visitor.number(
      {"threshold", -1, 1, "-", "Matches whose affinity is at most this are in conflict; negative: none are"},
      &StOptions::threshold);
  visitor.number({"sigma", 0.01, 1000, "px", "Difference: the affinity is zero from three times this on"},
                 &StOptions::sigma);
  visitor.number({"duplicate_affinity", 0, 1, "-", "Ratio: affinity of two equal matches"},
                 &StOptions::duplicate_affinity);
  visitor.number({"noise_floor", 0, 1000, "px",
                  "Matches whose distances differ by no more than this are never in conflict; 0 = off"},
                 &StOptions::noise_floor);
  visitor.flag("one_to_one", "Matches that share a point in one image only are in conflict",
               &StOptions::one_to_one);
  visitor.integer(
      {"memory_limit", 0, 1 << 20, "MiB",
       "Affinities that need more than this are computed again in every step, with the same result"},
      &StOptions::memory_limit);
  visitor.integer({"threads", 1, 1024, "-", "Threads for large inputs; results do not depend on it"},
                  &StOptions::threads);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &StOptions::max_seconds);
  visitConfidence(visitor);
}

Presets StSelector::presets() const {
  return {{"leordeanu_hebert", {{"affinity", "difference"}, {"threshold", "-1"}, {"one_to_one", "true"}}}};
}

void StSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n == 0) return;
  const Deadline deadline(options_.max_seconds);
  PairMemory& space = workspace.part<PairMemory>();
  const bool ratio = options_.affinity == StOptions::Affinity::kRatio;
  const PairValue value = ratio ? PairValue::kRatio : PairValue::kDifference;
  const PairRule rule = ruleOf(options_);
  space.assign(matches, value, rule, options_.memory_limit);
  const double duplicate_affinity = ratio ? options_.duplicate_affinity : 1;
  PrincipalEigenvector method(space, workspace.part<LanczosMemory>(), duplicate_affinity, options_.threads,
                              deadline);
  const Vector v = method.compute();
  result.iterations = method.products();
  space.matrix.release();
  if (!writeScores(space.distinct, v.data(), method.timedOut(), options_.max_seconds, result)) return;
  const std::vector<std::uint8_t> selected =
      withoutConflicts(v, value, rule, options_.threads, space.distinct);
  const bool one_of_equals = duplicate_affinity <= options_.threshold && options_.noise_floor == 0;
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t match = space.distinct.ofRow(i);
    if (!one_of_equals || space.distinct.firstRow(match) == i) result.mask[i] = selected[match];
  }
}

}  // namespace corrsel::core
