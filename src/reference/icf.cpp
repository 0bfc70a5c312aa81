#include "corrsel/reference/icf.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "base/coordinate_order.h"
#include "base/deadline.h"
#include "base/text.h"
#include "kernels/kernels.h"
#include "selectors/parts/degenerate_input.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 5;
constexpr std::size_t kMaxKernels = 100, kPolynomials = 3;
constexpr double kTolerance = 1e-4;  // of the elements of the kernel matrix
constexpr int kSteps = 4;            // of reweighted least squares
constexpr double kMinRidge = 1e-9;   // of the affine part, relative to the sum of the weights
constexpr std::size_t kTargets = 2;  // columns of the samples

/// The points of one image, centred and scaled to a mean squared radius of 1.
struct Points {
  std::vector<double> x, y;
};

std::size_t paddedSize(std::size_t n) { return (n + kFieldGroup - 1) / kFieldGroup * kFieldGroup; }

void normalise(const std::vector<float>& from_x, const std::vector<float>& from_y,
               const std::vector<KeyedRow>& rows, Points& to) {
  const std::size_t n = rows.size();
  to.x.assign(paddedSize(n), 0.0);
  to.y.assign(paddedSize(n), 0.0);
  double mean_x = 0, mean_y = 0, squared = 0;
  for (std::size_t i = 0; i < n; ++i) {
    mean_x += from_x[rows[i].row];
    mean_y += from_y[rows[i].row];
  }
  mean_x /= static_cast<double>(n);
  mean_y /= static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    to.x[i] = from_x[rows[i].row] - mean_x;
    to.y[i] = from_y[rows[i].row] - mean_y;
    squared += to.x[i] * to.x[i] + to.y[i] * to.y[i];
  }
  const double scale = std::sqrt(static_cast<double>(n) / squared);
  for (std::size_t i = 0; i < n; ++i) {
    to.x[i] *= scale;
    to.y[i] *= scale;
  }
}

/// A smooth function of the points of one image.
class CorrespondenceFunction {
 public:
  /// @param to_x, to_y  the points of the other image, px
  void start(const Points& points, const std::vector<float>& to_x, const std::vector<float>& to_y,
             const std::vector<KeyedRow>& rows, double beta) {
    n_ = rows.size();
    padded_ = paddedSize(n_);
    stride_ = (padded_ / kFieldGroup | 1U) * kFieldGroup;
    kernels_ = 0;
    columns_.assign(kTargets * stride_, 0.0);
    double mean_x = 0, mean_y = 0;
    for (std::size_t i = 0; i < n_; ++i) {
      mean_x += to_x[rows[i].row];
      mean_y += to_y[rows[i].row];
    }
    mean_x /= static_cast<double>(n_);
    mean_y /= static_cast<double>(n_);
    for (std::size_t i = 0; i < n_; ++i) {
      columns_[i] = to_x[rows[i].row] - mean_x;
      columns_[stride_ + i] = to_y[rows[i].row] - mean_y;
    }
    addKernelColumns(points, beta);
    const std::size_t end = columns_.size();
    columns_.resize(end + kPolynomials * stride_, 0.0);
    for (std::size_t i = 0; i < n_; ++i) {
      columns_[end + i] = 1;
      columns_[end + stride_ + i] = points.x[i];
      columns_[end + 2 * stride_ + i] = points.y[i];
    }
    error.assign(padded_, 0.0);
    weight_.assign(padded_, 0.0);
  }

  /// Fits the function to the active matches and computes the errors of all.
  void fit(const std::vector<std::uint8_t>& active, const IcfOptions& options) {
    for (int step = 0; step < kSteps; ++step) {
      for (std::size_t i = 0; i < n_; ++i)
        weight_[i] = active[i] == 0 ? 0.0 : step == 0 ? 1.0 : 1 / std::max(error[i], options.epsilon);
      solve(options.lambda);
      for (std::size_t i = 0; i < n_; ++i) error[i] = std::sqrt(error[i]);
    }
  }

  std::vector<double> error;  ///< of every match, px

 private:
  FieldFactor factor(std::size_t rank) const { return {columns_.data(), stride_, rank, padded_}; }

  /// Appends the columns of a pivoted Cholesky factor of the kernel matrix.
  void addKernelColumns(const Points& points, double beta) {
    rest_.assign(padded_, 1.0);
    std::fill(rest_.begin() + static_cast<std::ptrdiff_t>(n_), rest_.end(), 0.0);
    for (; kernels_ < kMaxKernels; ++kernels_) {
      const auto largest = std::max_element(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(n_));
      if (*largest <= kTolerance) break;
      const auto pivot = static_cast<std::size_t>(largest - rest_.begin());
      columns_.resize((kTargets + kernels_ + 1) * stride_, 0.0);
      double row[kMaxKernels];
      for (std::size_t j = 0; j < kernels_; ++j) row[j] = columns_[(kTargets + j) * stride_ + pivot];
      const double x = points.x[pivot], y = points.y[pivot], rest = *largest;
      const FieldPivots pivots{1, &x, &y, &rest, row, kMaxKernels};
      kernels().field.factor(points.x.data(), points.y.data(), beta, pivots, factor(kernels_),
                             columns_.data() + (kTargets + kernels_) * stride_, rest_.data());
      rest_[pivot] = 0;
    }
  }

  /// Weighted least squares with a ridge on the kernel part. Writes the squared errors.
  void solve(double lambda) {
    const std::size_t rank = kernels_ + kPolynomials, m = rank + kTargets;
    lanes_.resize(std::max(lanes_.size(), m * m * kFieldGroup));
    gram_.resize(m * m);
    solution_.resize(2 * rank);
    kernels().field.gram(factor(rank), weight_.data(), lanes_.data(), gram_.data());
    // The sum of the weights is the product of the constant with itself.
    const double weights = gram_[(kernels_ + kTargets) * m + kernels_ + kTargets];
    const double ridge = lambda * weights / static_cast<double>(n_), min_ridge = kMinRidge * weights;
    for (std::size_t j = 0; j < rank; ++j) {
      gram_[(j + kTargets) * m + j + kTargets] += j < kernels_ ? ridge : min_ridge;
      solution_[2 * j] = gram_[j + kTargets];
      solution_[2 * j + 1] = gram_[m + j + kTargets];
    }
    const auto size = static_cast<Eigen::Index>(rank);
    // The upper half of the row-major products is the lower half of a column-major matrix.
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> gram(gram_.data() + kTargets * m + kTargets, size,
                                                              size, Eigen::OuterStride<>(size + 2));
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>> solution(solution_.data(), size, 2);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>> cholesky(gram);
    cholesky.solveInPlace(solution);
    kernels().field.residuals(factor(rank), solution_.data(), weight_.data(), error.data());
  }

  std::size_t n_ = 0, padded_ = 0, stride_ = 0, kernels_ = 0;
  std::vector<double> columns_;  // samples, kernels, affine part
  std::vector<double> rest_, weight_, lanes_, gram_, solution_;
};

/// Memory that is kept between calls.
struct IcfMemory {
  std::vector<KeyedRow> rows, scratch;  // matches in the order of their coordinates
  Points left, right;
  CorrespondenceFunction forward, backward;
  std::vector<std::uint8_t> active;
};

/// Keeps those of the candidates that agree with both functions. @return their number
std::size_t keep(double threshold, IcfMemory& work) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < work.active.size(); ++i) {
    const bool agrees = work.forward.error[i] < threshold && work.backward.error[i] < threshold;
    work.active[i] = work.active[i] != 0 && agrees ? 1 : 0;
    count += work.active[i];
  }
  return count;
}

}  // namespace

void IcfOptions::visit(OptionVisitor& visitor) const {
  visitor.number(
      {"beta", 0.001, 10, "-", "Kernel exp(-beta d^2), d in normalised units; larger allows finer motion"},
      &IcfOptions::beta);
  visitor.number({"lambda", 1e-6, 1000, "-", "Weight of the smoothness"}, &IcfOptions::lambda);
  visitor.number({"epsilon", 0.01, 100, "px", "Errors below this have the same weight"},
                 &IcfOptions::epsilon);
  visitor.number({"first_threshold", 0.1, 10000, "px", "Largest error in the first round"},
                 &IcfOptions::first_threshold);
  visitor.number(
      {"last_threshold", 0.1, 10000, "px", "Largest error in the last round and of a selected match"},
      &IcfOptions::last_threshold);
  visitor.integer({"rounds", 1, 50, "-", "Rounds of fitting and removing"}, &IcfOptions::rounds);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &IcfOptions::max_seconds);
  visitConfidence(visitor);
}

void IcfOptions::check() const {
  ConfidenceOptions::check();
  if (last_threshold > first_threshold) {
    throw std::invalid_argument("option last_threshold = " + formatNumber(last_threshold) +
                                " is above first_threshold = " + formatNumber(first_threshold));
  }
}

void IcfSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n < kMinMatches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " matches, icf needs " + std::to_string(kMinMatches);
    return;
  }
  if (endsAtEqualPoints(matches, result)) return;
  const Deadline deadline(options_.max_seconds);
  IcfMemory& work = workspace.part<IcfMemory>();
  sortByCoordinates(matches, work.rows, work.scratch);
  normalise(matches.left_x, matches.left_y, work.rows, work.left);
  normalise(matches.right_x, matches.right_y, work.rows, work.right);
  work.forward.start(work.left, matches.right_x, matches.right_y, work.rows, options_.beta);
  work.backward.start(work.right, matches.left_x, matches.left_y, work.rows, options_.beta);
  work.active.assign(n, 1);
  bool timed_out = false;
  // The last fit is evaluated at all matches.
  for (int round = 0; round <= options_.rounds && !timed_out; ++round) {
    timed_out = deadline.passed();
    if (timed_out) break;
    work.forward.fit(work.active, options_);
    work.backward.fit(work.active, options_);
    if (round == options_.rounds) {
      work.active.assign(n, 1);
      keep(options_.last_threshold, work);
      break;
    }
    const double share = options_.rounds > 1 ? static_cast<double>(round) / (options_.rounds - 1) : 1.0;
    const double threshold =
        options_.first_threshold * std::pow(options_.last_threshold / options_.first_threshold, share);
    ++result.iterations;
    if (keep(threshold, work) < kMinMatches) {
      result.message = "fewer than " + std::to_string(kMinMatches) + " matches agree after round " +
                       std::to_string(result.iterations);
      return;
    }
  }
  if (timed_out) {
    result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
    result.message = "stopped after " + std::to_string(result.iterations) +
                     " rounds, max_seconds = " + formatNumber(options_.max_seconds);
    if (result.iterations == 0) return;
  }
  result.score.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t row = work.rows[i].row;
    result.mask[row] = work.active[i];
    result.score[row] = -static_cast<float>(std::max(work.forward.error[i], work.backward.error[i]));
  }
}

}  // namespace corrsel::core
