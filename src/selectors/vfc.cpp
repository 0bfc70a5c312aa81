#include "corrsel/selectors/vfc.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <new>
#include <optional>
#include <utility>
#include <vector>

#include "base/coordinate_order.h"
#include "base/deadline.h"
#include "base/text.h"
#include "corrsel/random.h"
#include "kernels/kernels.h"
#include "selectors/parts/trusted_set.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 5;
constexpr double kPi = 3.14159265358979323846;
// Constants of the authors' code.
constexpr double kMinPosterior = 1e-5, kMinVariance = 1e-8;
constexpr double kMinInlierRatio = 0.05, kMaxInlierRatio = 0.95;
// Where the field vanishes from the start, matches within ten times the smallest standard deviation are
// right.
constexpr double kMaxResidualAtRest = 1e-3;
// Points spread over an image need a tenth of this.
constexpr std::size_t kMaxRank = 400;
// Number of points among which pivots are sought, and the smallest step between two of them.
constexpr std::size_t kPilots = 256, kMinPilotStep = 4;
constexpr double kPilotMargin = 2;
// Points whose columns are computed between two readings of the clock: a few milliseconds with the most
// columns.
constexpr std::size_t kPointsPerLook = 1024;
// Columns that start from less than this hold rounding errors.
constexpr double kMinTolerance = 1e-13;
// The share of inliers among all, after the field was fitted to the trusted ones.
constexpr double kFirstShare = 0.1, kMinShare = 0.01, kMaxShare = 0.95, kCountedPosterior = 0.5;
constexpr int kShareSteps = 5;

/// Memory aligned like the lines of the cache, which keeps vectors from straddling two of them.
template <class T>
struct CacheAligned {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  CacheAligned() = default;
  template <class U>
  explicit CacheAligned(const CacheAligned<U>&) {}
  T* allocate(std::size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, std::size_t) { ::operator delete(p, kAlignment); }
  friend bool operator==(const CacheAligned&, const CacheAligned&) { return true; }
  friend bool operator!=(const CacheAligned&, const CacheAligned&) { return false; }
};
using Numbers = std::vector<double, CacheAligned<double>>;

/// Memory that is kept between calls.
struct VfcMemory {
  std::vector<KeyedRow> keyed, scratch;
  std::vector<std::uint32_t> rows;  // matches in the order of their coordinates
  Numbers x, y;                     // left points, normalised
  Numbers posterior, squared;       // squared = squared residuals
  Numbers columns, rest;            // field samples and factor of the kernel matrix; the diagonal left over
  Numbers pilot_x, pilot_y, pilot_columns, pilot_rest;  // the same for the pilot points
  Numbers pivot_x, pivot_y, pivot_rest, pivot_rows;     // pivots found among them
  Numbers lanes, gram, solution;
  std::vector<std::uint32_t> pilots;
  TrustedSet trusted;
};

std::size_t paddedSize(std::size_t n) { return (n + kFieldGroup - 1) / kFieldGroup * kFieldGroup; }

/// Distance of two columns: an odd number of groups keeps them from falling onto the same lines of the cache.
std::size_t columnStride(std::size_t n) { return (paddedSize(n) / kFieldGroup | 1U) * kFieldGroup; }

/// Writes the rows in the order of their coordinates. Sums then round the same way for any order of the
/// input.
void sortRows(const Correspondences& matches, VfcMemory& work) {
  sortByCoordinates(matches, work.keyed, work.scratch);
  work.rows.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) work.rows[i] = work.keyed[i].row;
}

/// Centre and scale of the points of one image.
struct Frame {
  double mean_x = 0, mean_y = 0, scale = 1;
};

/// The first n points of one image in the order of `rows`, centred and scaled to a mean squared radius of 1.
/// @return nothing where all are equal
std::optional<Frame> normalise(const std::vector<float>& from_x, const std::vector<float>& from_y,
                               const std::vector<std::uint32_t>& rows, std::size_t n, double* x, double* y) {
  bool equal = true;
  double mean_x = 0, mean_y = 0, squared = 0;
  for (std::size_t i = 0; i < n; ++i) {
    x[i] = from_x[rows[i]];
    y[i] = from_y[rows[i]];
    equal = equal && x[i] == x[0] && y[i] == y[0];
    mean_x += x[i];
    mean_y += y[i];
  }
  if (equal) return std::nullopt;
  mean_x /= static_cast<double>(n);
  mean_y /= static_cast<double>(n);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] -= mean_x;
    y[i] -= mean_y;
    squared += x[i] * x[i] + y[i] * y[i];
  }
  const double scale = std::sqrt(static_cast<double>(n) / squared);
  for (std::size_t i = 0; i < n; ++i) {
    x[i] *= scale;
    y[i] *= scale;
  }
  return Frame{mean_x, mean_y, scale};
}

/// Points of one image in the order of `rows`, centred and scaled as given.
void place(const std::vector<float>& from_x, const std::vector<float>& from_y,
           const std::vector<std::uint32_t>& rows, const Frame& frame, double* x, double* y) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    x[i] = (from_x[rows[i]] - frame.mean_x) * frame.scale;
    y[i] = (from_y[rows[i]] - frame.mean_y) * frame.scale;
  }
}

/// Draws rows of distinct left points, all of them if there are no more than `count`.
void drawControlPoints(std::size_t n, std::size_t count, std::uint64_t seed, VfcMemory& work) {
  std::vector<std::uint32_t>& points = work.pilots;
  points.clear();
  for (std::uint32_t i = 0; i < n; ++i) {
    if (i == 0 || work.x[i] != work.x[i - 1] || work.y[i] != work.y[i - 1]) points.push_back(i);
  }
  if (points.size() <= count) return;
  std::vector<std::uint32_t> drawn(count);
  Random(seed).sample(static_cast<std::uint32_t>(points.size()), count, drawn.data());
  for (std::uint32_t& index : drawn) index = points[index];
  points.assign(drawn.begin(), drawn.end());
}

/// Every so many rows of the points in the order of their coordinates.
void takePilots(std::size_t n, VfcMemory& work) {
  const std::size_t step = std::max(kMinPilotStep, n / kPilots);
  work.pilots.clear();
  for (std::size_t i = step / 2; i < n; i += step) work.pilots.push_back(static_cast<std::uint32_t>(i));
}

std::size_t largestOf(const Numbers& numbers, std::size_t n) {
  const auto end = numbers.begin() + static_cast<std::ptrdiff_t>(n);
  return static_cast<std::size_t>(std::max_element(numbers.begin(), end) - numbers.begin());
}

/// Whole groups of points: the last one is repeated.
void fillGroup(Numbers& column, std::size_t n) { column.resize(paddedSize(n), column[n - 1]); }

/// The field as the factor of its kernel matrix, K ~ L L^T, by pivoted Cholesky. A few pilot points find the
/// pivots, so that all columns of a step are made in one pass over the points; where that leaves too much of
/// the diagonal elsewhere, further pivots are taken there. With the control points as the pilots and no
/// further pivots this is SparseVFC: with its kernel matrices U (points x control points) and G (among
/// control points), L = U R^-1 for G = R^T R, and w = R c turns its system (U^T P U + ridge G) c = U^T P Y
/// into the one of w.
class Field {
 public:
  Field(std::size_t n, const VfcOptions& options, const Deadline& deadline, VfcMemory& work)
      : n_(n), beta_(options.beta), sparse_(options.control_points > 0), deadline_(deadline), work_(work) {
    if (sparse_) {
      drawControlPoints(n, static_cast<std::size_t>(options.control_points),
                        static_cast<std::uint64_t>(options.seed), work);
    } else {
      takePilots(n, work);
    }
    work.pilot_x.clear();
    work.pilot_y.clear();
    for (const std::uint32_t row : work.pilots) {
      work.pilot_x.push_back(work.x[row]);
      work.pilot_y.push_back(work.y[row]);
    }
    fillGroup(work.pilot_x, work.pilots.size());
    fillGroup(work.pilot_y, work.pilots.size());
    for (Numbers* column : {&work.pivot_x, &work.pivot_y, &work.pivot_rest, &work.pivot_rows})
      column->clear();
    work.pilot_rest.assign(work.pilot_x.size(), 1.0);
    work.rest.assign(work.x.size(), 1.0);
  }

  /// Fits to the samples: w of (L^T P L + ridge I) w = L^T P Y, L L^T being exact up to `tolerance` in every
  /// element. Writes the squared residuals. @return their sum weighted by the posteriors; nothing, and
  /// nothing is written, where the deadline has passed
  std::optional<double> fit(double ridge, double tolerance) {
    if (deadline_.passed() || !extend(tolerance)) return std::nullopt;
    const FieldFactor factor = factorOf(work_.columns, n_, rank_);
    fitted_ = rank_;
    const std::size_t m = rank_ + 2;
    work_.lanes.resize(std::max(work_.lanes.size(), m * m * kFieldGroup));
    work_.gram.resize(m * m);
    work_.solution.resize(2 * rank_);
    kernels().field.gram(factor, work_.posterior.data(), work_.lanes.data(), work_.gram.data());
    for (std::size_t j = 0; j < rank_; ++j) {
      work_.gram[(j + 2) * m + j + 2] += ridge;
      work_.solution[2 * j] = work_.gram[j + 2];
      work_.solution[2 * j + 1] = work_.gram[m + j + 2];
    }
    const auto rank = static_cast<Eigen::Index>(rank_);
    // The upper half of the row-major products is the lower half of a column-major matrix.
    Eigen::Map<Eigen::MatrixXd, 0, Eigen::OuterStride<>> gram(work_.gram.data() + 2 * m + 2, rank, rank,
                                                              Eigen::OuterStride<>(rank + 2));
    Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>> solution(work_.solution.data(),
                                                                                   rank, 2);
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd, 0, Eigen::OuterStride<>>> cholesky(gram);
    cholesky.solveInPlace(solution);
    norm_ = solution.squaredNorm();
    return kernels().field.residuals(factor, work_.solution.data(), work_.posterior.data(),
                                     work_.squared.data());
  }

  /// |w|^2 of the last fit, which is tr(C^T K C) for f = K C.
  double norm() const { return norm_; }

  /// Writes the squared residuals of n other samples, which stand at the begin of `columns`, under the last
  /// field that was fitted. work.x and work.y hold their points. The field cannot be fitted again after that.
  void evaluate(std::size_t n) {
    n_ = n;
    rank_ = 0;
    work_.rest.assign(paddedSize(n), 1.0);
    work_.squared.assign(paddedSize(n), 0.0);
    work_.posterior.assign(paddedSize(n), 0.0);
    if (fitted_ > 0) add(pivotsFrom(0, fitted_), work_.x, work_.y, n, 0, work_.columns, work_.rest, nullptr);
    kernels().field.residuals(factorOf(work_.columns, n, fitted_), work_.solution.data(),
                              work_.posterior.data(), work_.squared.data());
  }

 private:
  static FieldFactor factorOf(const Numbers& columns, std::size_t n, std::size_t rank) {
    return {columns.data(), columnStride(n), rank, paddedSize(n)};
  }

  /// Adds columns until all elements are exact up to `tolerance`. @return false where the deadline has passed
  bool extend(double tolerance) {
    // Between the pilots more is left over than at them.
    const double at_pilots = std::max(kMinTolerance, sparse_ ? 0.0 : tolerance / kPilotMargin);
    while (pivots() < kMaxRank) {
      const std::size_t next = largestOf(work_.pilot_rest, work_.pilots.size());
      if (work_.pilot_rest[next] <= at_pilots && pivots() > 0) break;
      if (deadline_.passed()) return false;
      takePivot(work_.pilot_x[next], work_.pilot_y[next], work_.pilot_rest[next], work_.pilot_columns,
                work_.pilots.size(), next);
      work_.pilot_rest[next] = 0;
    }
    if (pivots() > rank_ && !addColumns()) return false;
    while (!sparse_ && largest_rest_ > tolerance && rank_ < kMaxRank) {
      const std::size_t next = largestOf(work_.rest, n_);
      takePivot(work_.x[next], work_.y[next], work_.rest[next], work_.columns, n_, next);
      if (!addColumns()) return false;
    }
    return true;
  }

  /// Pivots so far; the points have columns for the first rank_ of them.
  std::size_t pivots() const { return work_.pivot_x.size(); }

  FieldPivots pivotsFrom(std::size_t begin, std::size_t end) const {
    return {end - begin,
            work_.pivot_x.data() + begin,
            work_.pivot_y.data() + begin,
            work_.pivot_rest.data() + begin,
            work_.pivot_rows.data() + begin * kMaxRank,
            kMaxRank};
  }

  /// Appends a pivot, whose row of the factor is `row` of `columns`, and gives the pilots its column.
  void takePivot(double x, double y, double rest, const Numbers& columns, std::size_t n, std::size_t row) {
    const std::size_t rank = pivots(), stride = columnStride(n);
    work_.pivot_x.push_back(x);
    work_.pivot_y.push_back(y);
    work_.pivot_rest.push_back(rest);
    work_.pivot_rows.resize(pivots() * kMaxRank);
    double* const elements = work_.pivot_rows.data() + (pivots() - 1) * kMaxRank;
    for (std::size_t j = 0; j < rank; ++j) elements[j] = columns[(j + 2) * stride + row];
    add(pivotsFrom(rank, rank + 1), work_.pilot_x, work_.pilot_y, work_.pilots.size(), rank,
        work_.pilot_columns, work_.pilot_rest, &deadline_);
  }

  /// Gives all points the columns of the pivots. @return false where the deadline has passed
  bool addColumns() {
    largest_rest_ =
        add(pivotsFrom(rank_, pivots()), work_.x, work_.y, n_, rank_, work_.columns, work_.rest, &deadline_);
    rank_ = pivots();
    return !deadline_.passed();
  }

  /// @return what is left of the diagonal, at most; stops at the deadline if there is one
  double add(const FieldPivots& pivots, const Numbers& x, const Numbers& y, std::size_t n, std::size_t rank,
             Numbers& columns, Numbers& rest, const Deadline* deadline) const {
    const std::size_t begin = (rank + 2) * columnStride(n), end = begin + pivots.count * columnStride(n);
    if (columns.size() < end) columns.resize(end * 3 / 2);
    double largest = 0;
    for (std::size_t i = 0; i < paddedSize(n); i += kPointsPerLook) {
      if (i > 0 && deadline != nullptr && deadline->passed()) break;
      FieldFactor part = factorOf(columns, n, rank);
      part.columns += i;
      part.padded = std::min(kPointsPerLook, part.padded - i);
      largest = std::max(largest, kernels().field.factor(x.data() + i, y.data() + i, beta_, pivots, part,
                                                         columns.data() + begin + i, rest.data() + i));
    }
    return largest;
  }

  std::size_t n_;
  double beta_;
  bool sparse_;
  const Deadline& deadline_;
  VfcMemory& work_;
  std::size_t rank_ = 0, fitted_ = 0;
  double largest_rest_ = 1, norm_ = 0;
};

/// The state of the EM between its steps.
struct Mixture {
  double variance;
  double share;  ///< of inliers
};

FieldPosteriorSums findPosteriors(const Mixture& mixture, const VfcOptions& options, double counted,
                                  std::size_t n, VfcMemory& work) {
  const FieldPosteriorRule rule{
      -0.5 / mixture.variance,
      2 * kPi * mixture.variance * (1 - mixture.share) / (mixture.share * options.outlier_area),
      kMinPosterior, counted};
  return kernels().field.posteriors(rule, work.squared.data(), n, work.posterior.data());
}

/// The EM. Leaves the posteriors in work.posterior: at the deadline those of the last field that was fitted.
/// @return its steps; at the deadline the fields fitted
int estimate(std::size_t n, const VfcOptions& options, Field& field, Mixture& mixture, VfcMemory& work,
             bool& timed_out) {
  double energy = 1;
  int steps = 0;
  while (steps < options.max_iterations && mixture.variance > kMinVariance) {
    ++steps;
    const FieldPosteriorSums sums = findPosteriors(mixture, options, options.threshold, n, work);
    const double before =
        std::exchange(energy, sums.weighted / (2 * mixture.variance) + sums.sum * std::log(mixture.variance) +
                                  options.lambda / 2 * field.norm());
    if (std::abs(energy - before) <= options.energy_change * std::abs(energy)) break;
    const double ridge = options.lambda * mixture.variance;
    const std::optional<double> rest =
        field.fit(ridge, std::max(kMinTolerance, options.kernel_tolerance * ridge));
    timed_out = !rest;
    if (timed_out) return steps - 1;
    mixture.variance = *rest / (2 * sums.clamped);
    mixture.share = std::clamp(sums.accepted / static_cast<double>(n), kMinInlierRatio, kMaxInlierRatio);
  }
  return steps;
}

/// Orders the rows by their coordinates, and the trusted ones first where the field is fitted to these alone.
/// @return the number of rows to fit to
std::size_t chooseRows(const Correspondences& matches, const VfcOptions& options, VfcMemory& work) {
  sortRows(matches, work);
  if (!options.guided) return matches.size();
  work.trusted.find(matches, options.guide_ratio);
  if (work.trusted.size() < TrustedSet::kMinMatches) return matches.size();
  work.rows.clear();
  for (const std::uint8_t trusted : {1, 0}) {
    for (const KeyedRow& row : work.keyed) {
      if (work.trusted.mask()[row.row] == trusted) work.rows.push_back(row.row);
    }
  }
  return work.trusted.size();
}

/// The right and left frames of the points that the field was fitted to.
struct Frames {
  Frame left, right;
};

/// Writes points and field samples of the first n rows. @return nothing where all points of an image are
/// equal
std::optional<Frames> layOut(const Correspondences& matches, std::size_t n, VfcMemory& work) {
  const std::size_t stride = columnStride(n);
  for (Numbers* column : {&work.x, &work.y, &work.squared, &work.posterior})
    column->assign(paddedSize(n), 0.0);
  if (work.columns.size() < 2 * stride) work.columns.resize(2 * stride);
  double *const u = work.columns.data(), *const v = u + stride;
  std::fill(u, v + stride, 0.0);
  const auto left = normalise(matches.left_x, matches.left_y, work.rows, n, work.x.data(), work.y.data());
  const auto right = normalise(matches.right_x, matches.right_y, work.rows, n, u, v);
  if (!left || !right) return std::nullopt;
  return Frames{*left, *right};
}

/// The displacements as field samples, and what stands behind the last point. @return their variance
double findDisplacements(std::size_t n, VfcMemory& work) {
  std::fill(work.x.begin() + static_cast<std::ptrdiff_t>(n), work.x.end(), work.x[n - 1]);
  std::fill(work.y.begin() + static_cast<std::ptrdiff_t>(n), work.y.end(), work.y[n - 1]);
  double *const u = work.columns.data(), *const v = u + columnStride(n);
  double variance = 0;
  for (std::size_t i = 0; i < n; ++i) {
    u[i] -= work.x[i];
    v[i] -= work.y[i];
    work.squared[i] = u[i] * u[i] + v[i] * v[i];
    variance += work.squared[i];
  }
  return variance / (2 * static_cast<double>(n));
}

/// Posteriors of all matches under a field that was fitted to the trusted ones.
void evaluateAll(const Correspondences& matches, const VfcOptions& options, const Frames& frames,
                 Field& field, Mixture mixture, VfcMemory& work) {
  const std::size_t n = matches.size(), stride = columnStride(n);
  work.x.resize(paddedSize(n));
  work.y.resize(paddedSize(n));
  if (work.columns.size() < 2 * stride) work.columns.resize(2 * stride);
  double *const u = work.columns.data(), *const v = u + stride;
  std::fill(u, v + stride, 0.0);
  place(matches.left_x, matches.left_y, work.rows, frames.left, work.x.data(), work.y.data());
  place(matches.right_x, matches.right_y, work.rows, frames.right, u, v);
  work.squared.resize(paddedSize(n));
  findDisplacements(n, work);
  field.evaluate(n);
  const double min_sigma = options.min_sigma * frames.right.scale;
  mixture = {std::max({mixture.variance, min_sigma * min_sigma, kMinVariance}), kFirstShare};
  for (int step = 0; step < kShareSteps; ++step) {
    const FieldPosteriorSums sums = findPosteriors(mixture, options, kCountedPosterior, n, work);
    mixture.share = std::clamp(sums.accepted / static_cast<double>(n), kMinShare, kMaxShare);
  }
  findPosteriors(mixture, options, options.threshold, n, work);
}

}  // namespace

void VfcOptions::visit(OptionVisitor& visitor) const {
  visitor.number(
      {"beta", 0.001, 10, "-", "Kernel exp(-beta d^2), d in normalised units; larger allows finer motion"},
      &VfcOptions::beta);
  visitor.number({"lambda", 0.001, 1000, "-", "Weight of the smoothness of the field"}, &VfcOptions::lambda);
  visitor.number({"threshold", 0, 1, "-", "A match is accepted if its posterior is above this"},
                 &VfcOptions::threshold);
  visitor.number({"inlier_ratio", 0.05, 0.95, "-", "Share of inliers that the iteration starts from"},
                 &VfcOptions::inlier_ratio);
  visitor.number({"outlier_area", 0.01, 10000, "-", "Area over which outliers spread, in normalised units"},
                 &VfcOptions::outlier_area);
  visitor.number({"energy_change", 0, 0.1, "-", "Stop once the energy changes by less than this share"},
                 &VfcOptions::energy_change);
  visitor.integer({"max_iterations", 1, 10000, "-", "Steps of the iteration at most"},
                  &VfcOptions::max_iterations);
  visitor.number({"kernel_tolerance", 0, 0.1, "-",
                  "Largest error of the factored kernel matrix, as a share of lambda s2"},
                 &VfcOptions::kernel_tolerance);
  visitor.integer({"control_points", 0, 200, "-", "Points that carry the field, drawn at random; 0 = all"},
                  &VfcOptions::control_points);
  visitor.flag("guided", "Fit the field to the trusted matches only, then evaluate it at all matches",
               &VfcOptions::guided);
  visitor.number({"guide_ratio", 0, 1, "-", "Guided: trusted matches have a distance ratio below this"},
                 &VfcOptions::guide_ratio);
  visitor.number({"min_sigma", 0, 100, "px",
                  "Guided: smallest standard deviation when the field is evaluated at all matches"},
                 &VfcOptions::min_sigma);
  visitor.integer({"seed", 0, 2147483647, "-", "Seed of the random numbers"}, &VfcOptions::seed);
  visitor.number({"max_seconds", 0, 1e6, "s", "Time limit; 0 = none"}, &VfcOptions::max_seconds);
  visitConfidence(visitor);
}

Presets VfcSelector::presets() const {
  return {{"sparse", {{"control_points", "16"}}}, {"guided", {{"guided", "true"}, {"lambda", "6"}}}};
}

std::string VfcSelector::missingInput(const Correspondences& matches) const {
  return options_.guided ? TrustedSet::missingInput(matches, "vfc with guided = true") : "";
}

void VfcSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n < kMinMatches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " matches, vfc needs " + std::to_string(kMinMatches);
    return;
  }
  const Deadline deadline(options_.max_seconds);
  VfcMemory& work = workspace.part<VfcMemory>();
  std::size_t fitted = chooseRows(matches, options_, work);
  std::optional<Frames> frames = layOut(matches, fitted, work);
  if (!frames && fitted < n) {
    fitted = n;
    sortRows(matches, work);
    frames = layOut(matches, fitted, work);
  }
  if (!frames) {
    result.status = Status::kDegenerate;
    result.message = "all points of an image are equal";
    return;
  }
  Mixture mixture{findDisplacements(fitted, work), options_.inlier_ratio};
  const bool at_rest = mixture.variance <= kMinVariance;
  Field field(fitted, options_, deadline, work);
  if (!at_rest) {
    bool timed_out = false;
    result.iterations = estimate(fitted, options_, field, mixture, work, timed_out);
    if (timed_out) {
      result.status = result.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit;
      result.message = "stopped after " + std::to_string(result.iterations) +
                       " steps, max_seconds = " + formatNumber(options_.max_seconds);
      if (result.iterations == 0) return;
    }
  }
  if (fitted < n) {
    evaluateAll(matches, options_, *frames, field, mixture, work);
  } else if (at_rest) {
    for (std::size_t i = 0; i < n; ++i)
      work.posterior[i] = work.squared[i] <= kMaxResidualAtRest * kMaxResidualAtRest ? 1.0 : 0.0;
  }
  result.score.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    result.mask[work.rows[i]] = work.posterior[i] > options_.threshold ? 1 : 0;
    result.score[work.rows[i]] = static_cast<float>(work.posterior[i]);
  }
}

}  // namespace corrsel::core
