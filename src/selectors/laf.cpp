#include "corrsel/selectors/laf.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <stdexcept>
#include <utility>
#include <vector>

#include "kernels/kernels.h"
#include "points/point_groups.h"
#include "selectors/parts/degenerate_input.h"
#include "selectors/parts/trusted_set.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kMinMatches = 8;
constexpr double kPi = 3.14159265358979323846;
constexpr double kMargin = 0.01;     // of the grid on each side of the points
constexpr double kDeviation = 0.08;  // squared motion at which the deviation is 1 - 1/e
// Motions below 1/16 of the largest one agree in the last round of the schedule: 0.08 ln(1 / 0.95) =
// 1/15.6^2.
constexpr double kMaxInNoiseFloors = 16;
// The noise floor is a difference of two motions in 95 % of the cases; this is one standard deviation.
constexpr double kNoiseFloorInSigmas = 7;
constexpr double kMinWeight = 1e-12, kMinVariance = 1e-12;
// Motions farther away than this are those of outliers in any case, and finite sums stay exact.
constexpr double kMaxMotion = 64;

constexpr int kMotionBits = 20, kDeviationBits = 34;  // of the fractions that are kept

constexpr std::array<double, 5> kDeviations = {0.8, 0.2, 0.1, 0.05, 0.05};  // lambda of the rounds

/// Rounds to a multiple of 2^-fraction_bits, so that sums of many such numbers are exact in any order.
/// @pre |value| < 2^(50 - fraction_bits)
inline double quantised(double value, int fraction_bits) {
  const double shift = 1.5 * static_cast<double>(std::uint64_t{1} << (52 - fraction_bits));
  return (value + shift) - shift;
}

/// A field of motions on a grid.
class MotionField {
 public:
  void start(int cells, int kernel_side) {
    if (cells == cells_ && kernel_side == 2 * reach_ + 1) return;
    cells_ = cells;
    reach_ = kernel_side / 2;
    width_ = static_cast<std::size_t>(cells + 2 * reach_);
    row_.resize(3 * static_cast<std::size_t>(reach_ + 1) * width_);
    const auto weights = static_cast<std::size_t>(reach_ + 1);
    weight_.resize(weights * weights);
    double sum = 0;
    for (int a = -reach_; a <= reach_; ++a) {
      for (int b = -reach_; b <= reach_; ++b) sum += std::exp(-std::sqrt(double(a * a + b * b)));
    }
    for (std::size_t a = 0; a < weights; ++a) {
      for (std::size_t b = 0; b < weights; ++b)
        weight_[a * weights + b] = std::exp(-std::sqrt(double(a * a + b * b))) / sum;
    }
  }

  /// Forgets the motions.
  void clear() {
    for (std::vector<double>& plane : sums_) plane.assign(width_ * width_, 0.0);
    const auto cells = static_cast<std::size_t>(cells_);
    for (std::vector<double>& plane : means_) plane.resize(cells * cells);
  }

  /// The number of the cell at x, y in [0, 1).
  std::uint32_t cell(double x, double y) const {
    return static_cast<std::uint32_t>(static_cast<int>(y * cells_) * cells_ + static_cast<int>(x * cells_));
  }

  /// Where add() counts the motions of a cell.
  std::uint32_t slot(std::uint32_t cell) const {
    const auto cells = static_cast<std::uint32_t>(cells_), reach = static_cast<std::uint32_t>(reach_);
    return (cell / cells + reach) * static_cast<std::uint32_t>(width_) + cell % cells + reach;
  }

  /// Adds a motion with the weight 1 or 0.
  void add(std::uint32_t slot, double weight, double x, double y) {
    sums_[0][slot] += weight;
    sums_[1][slot] += weight * x;
    sums_[2][slot] += weight * y;
  }

  /// Computes the mean motion around every cell, without the cell itself.
  void filter() {
    const auto cells = static_cast<std::size_t>(cells_), reach = static_cast<std::size_t>(reach_);
    for (std::size_t row = 0; row < cells; ++row) {
      filterRow(row + reach);
      for (std::size_t column = 0; column < cells; ++column) {
        const std::size_t at = (row + reach) * width_ + column + reach, mean = row * cells + column;
        const double count = sums_[0][at], centre = count > 0 ? weight_[0] : 0.0;
        const double weight = filtered_[column] - centre;
        const double own = count > 0 ? centre / count : 0.0;
        const double scale = weight > kMinWeight ? 1 / weight : 0.0;
        means_[0][mean] = (filtered_[cells + column] - own * sums_[1][at]) * scale;
        means_[1][mean] = (filtered_[2 * cells + column] - own * sums_[2][at]) * scale;
      }
    }
  }

  double meanX(std::uint32_t cell) const { return means_[0][cell]; }
  double meanY(std::uint32_t cell) const { return means_[1][cell]; }

 private:
  /// Correlates the sums around a row of the padded grid with the kernel. The kernel is symmetric, so that
  /// rows and columns at equal distances are added before they are weighted.
  void filterRow(std::size_t row) {
    const auto cells = static_cast<std::size_t>(cells_), reach = static_cast<std::size_t>(reach_);
    filtered_.assign(3 * cells, 0.0);
    for (std::size_t plane = 0; plane < 3; ++plane) {
      double* const out = filtered_.data() + plane * cells;
      for (std::size_t a = 0; a <= reach; ++a) {
        const double* const above = sums_[plane].data() + (row - a) * width_;
        const double* const below = sums_[plane].data() + (row + a) * width_;
        double* const both = row_.data();
        for (std::size_t k = 0; k < width_; ++k) both[k] = a == 0 ? above[k] : above[k] + below[k];
        const double* const weight = weight_.data() + a * (reach + 1);
        const double* const centre = both + reach;
        std::size_t b = 1;
        if (reach >= 4) {
          // The sums of the loops below in one pass, for the usual size of the kernel.
          const double w0 = weight[0], w1 = weight[1], w2 = weight[2], w3 = weight[3], w4 = weight[4];
          for (std::size_t k = 0; k < cells; ++k) {
            const double* const c = centre + k;
            double sum = out[k] + w0 * c[0];
            sum += w1 * (c[-1] + c[1]) + w2 * (c[-2] + c[2]);
            sum += w3 * (c[-3] + c[3]) + w4 * (c[-4] + c[4]);
            out[k] = sum;
          }
          b = 5;
        } else {
          for (std::size_t k = 0; k < cells; ++k) out[k] += weight[0] * centre[k];
        }
        for (; b + 1 <= reach; b += 2) {
          const double *const left = centre - b, *const right = centre + b;
          for (std::size_t k = 0; k < cells; ++k)
            out[k] += weight[b] * (left[k] + right[k]) + weight[b + 1] * ((left - 1)[k] + (right + 1)[k]);
        }
        for (; b <= reach; ++b) {
          const double *const left = centre - b, *const right = centre + b;
          for (std::size_t k = 0; k < cells; ++k) out[k] += weight[b] * (left[k] + right[k]);
        }
      }
    }
  }

  int cells_ = 0, reach_ = 0;
  std::size_t width_ = 0;        // of the grid with a border of the kernel's reach
  std::vector<double> weight_;   // of the kernel's lower right quarter
  std::vector<double> sums_[3];  // number, motion in x, motion in y
  std::vector<double> means_[2];
  std::vector<double> row_, filtered_;
};

/// Memory that is kept between calls.
struct LafMemory {
  MotionField field;
  TrustedSet trusted;
  PointGroups left, right;
  std::vector<double> x, y, motion_x, motion_y, squared, posterior;
  std::vector<std::uint32_t> cell, slot;
  std::vector<std::uint8_t> unique, active, next;
};

bool isInside(float x, float y, const cv::Size& size) {
  return size.width <= 0 || size.height <= 0 ||
         (x >= -1 && y >= -1 && x <= static_cast<float>(size.width) && y <= static_cast<float>(size.height));
}

/// Scales the left points to [kMargin, 1 - kMargin] and the motions to [-1, 1]. Matches with a point outside
/// of its image do not determine the scales, unless all are outside.
/// @return the variance of the localisation noise in units of the motions
double scale(const Correspondences& m, double noise_floor, LafMemory& work) {
  const std::size_t n = m.size();
  double low[2] = {}, high[2] = {}, largest[2] = {};
  bool any = false;
  for (const bool inside_only : {true, false}) {
    if (any) break;
    for (std::size_t i = 0; i < n; ++i) {
      if (inside_only && !(isInside(m.left_x[i], m.left_y[i], m.left_size) &&
                           isInside(m.right_x[i], m.right_y[i], m.right_size)))
        continue;
      const double point[2] = {m.left_x[i], m.left_y[i]};
      const double motion[2] = {double{m.right_x[i]} - m.left_x[i], double{m.right_y[i]} - m.left_y[i]};
      for (int axis = 0; axis < 2; ++axis) {
        low[axis] = any ? std::min(low[axis], point[axis]) : point[axis];
        high[axis] = any ? std::max(high[axis], point[axis]) : point[axis];
        largest[axis] = std::max(largest[axis], std::abs(motion[axis]));
      }
      any = true;
    }
  }
  double per_px[2], per_motion[2];
  for (int axis = 0; axis < 2; ++axis) {
    per_px[axis] = high[axis] > low[axis] ? (1 - 2 * kMargin) / (high[axis] - low[axis]) : 0.0;
    const double unit = std::max(largest[axis], kMaxInNoiseFloors * noise_floor);
    per_motion[axis] = unit > 0 ? 1 / unit : 0.0;
  }
  for (std::vector<double>* column : {&work.x, &work.y, &work.motion_x, &work.motion_y}) column->resize(n);
  const auto place = [&](double value, int axis) {
    return std::min(std::max((value - low[axis]) * per_px[axis], 0.0), 1 - 2 * kMargin) + kMargin;
  };
  const auto motion = [&](double from, double to, int axis) {
    return quantised(std::min(std::max((to - from) * per_motion[axis], -kMaxMotion), kMaxMotion),
                     kMotionBits);
  };
  for (std::size_t i = 0; i < n; ++i) {
    work.x[i] = place(m.left_x[i], 0);
    work.y[i] = place(m.left_y[i], 1);
    work.motion_x[i] = motion(m.left_x[i], m.right_x[i], 0);
    work.motion_y[i] = motion(m.left_y[i], m.right_y[i], 1);
  }
  const double sigma = noise_floor / kNoiseFloorInSigmas;
  return sigma * sigma * (per_motion[0] * per_motion[0] + per_motion[1] * per_motion[1]) / 2;
}

/// Marks the matches that share neither their left nor their right pixel.
void markUnique(const Correspondences& m, LafMemory& work) {
  work.left.number(m.left_x, m.left_y, 1);
  work.right.number(m.right_x, m.right_y, 1);
  work.unique.resize(m.size());
  for (std::size_t i = 0; i < m.size(); ++i)
    work.unique[i] = work.left.sizes[work.left.of[i]] == 1 && work.right.sizes[work.right.of[i]] == 1 ? 1 : 0;
}

/// Computes the squared deviations from the field. @return how many are below `largest`, and their sum
std::pair<double, double> compare(std::size_t n, double largest, LafMemory& work) {
  const double *const x = work.motion_x.data(), *const y = work.motion_y.data();
  const std::uint32_t* const cell = work.cell.data();
  double* const squared = work.squared.data();
  for (std::size_t i = 0; i < n; ++i) {
    const double dx = x[i] - work.field.meanX(cell[i]), dy = y[i] - work.field.meanY(cell[i]);
    squared[i] = dx * dx + dy * dy;
  }
  // Bits of positive numbers have the order of the numbers; the loop has no branches. The sum is exact.
  std::uint64_t close = 0, limit = 0;
  std::memcpy(&limit, &largest, sizeof limit);
  double sum = 0;
  for (std::size_t i = 0; i < n; ++i) {
    squared[i] = quantised(squared[i], kDeviationBits);
    std::uint64_t bits = 0;
    std::memcpy(&bits, squared + i, sizeof bits);
    const std::uint64_t is_close = bits < limit ? 1 : 0;
    close += is_close;
    bits &= 0 - is_close;
    double summand = 0;
    std::memcpy(&summand, &bits, sizeof summand);
    sum += summand;
  }
  return {static_cast<double>(close), sum};
}

/// Finds the next active matches, those below `limit`. @return their number
std::size_t activate(std::size_t n, double limit, LafMemory& work) {
  const double* const squared = work.squared.data();
  const std::uint8_t* const unique = work.unique.data();
  std::uint8_t* const next = work.next.data();
  unsigned active = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const unsigned is_active = unsigned{unique[i]} & (squared[i] < limit ? 1U : 0U);
    next[i] = static_cast<std::uint8_t>(is_active);
    active += is_active;
  }
  return active;
}

/// Iterates between the motion field and the matches that agree with it.
/// @param rule  receives that of the last round
/// @return false if no match agrees with the field of some round
bool iterate(const LafOptions& options, std::size_t n, double min_variance, LafMemory& work,
             FieldPosteriorRule& rule, Selection& result) {
  for (int k = 0; k < options.rounds; ++k) {
    work.field.clear();
    for (std::size_t i = 0; i < n; ++i)
      work.field.add(work.slot[i], work.active[i], work.motion_x[i], work.motion_y[i]);
    work.field.filter();
    const double largest =
        -kDeviation *
        std::log1p(-kDeviations[std::min<std::size_t>(static_cast<std::size_t>(k), kDeviations.size() - 1)]);
    const auto [close, sum] = compare(n, largest, work);
    if (close == 0) {
      result.message = "no match agrees with the field of round " + std::to_string(k + 1);
      return false;
    }
    const double variance = std::max(sum / close / 2, min_variance), share = close / static_cast<double>(n);
    rule.exponent = -0.5 / variance;
    rule.outlier = 2 * kPi * variance * (1 - share) / (options.outlier_area * share);
    rule.threshold = options.accept;
    ++result.iterations;
    const double odds = options.accept / (1 - options.accept) * rule.outlier;
    const double limit = odds > 0 ? std::log(odds) / rule.exponent : 1e300;
    const std::size_t active = activate(n, limit, work);
    if (active > 0) work.active.swap(work.next);
  }
  return true;
}

}  // namespace

void LafOptions::visit(OptionVisitor& visitor) const {
  visitor.integer({"rounds", 1, 20, "-", "Rounds that run; the fifth one is repeated"}, &LafOptions::rounds);
  visitor.number({"accept", 0.5, 0.99, "-", "A match is accepted if its posterior is above this"},
                 &LafOptions::accept);
  visitor.number({"outlier_area", 0.1, 1000, "-",
                  "Area over which outliers spread, in units of the largest motion along each axis"},
                 &LafOptions::outlier_area);
  visitor.integer({"min_cells", 3, 100, "cells", "Cells per side of the grid at least"},
                  &LafOptions::min_cells);
  visitor.integer({"max_cells", 3, 100, "cells", "Cells per side of the grid at most"},
                  &LafOptions::max_cells);
  visitor.number({"noise_floor", 0, 1000, "px", "Motions that differ by at most this agree; 0 = off"},
                 &LafOptions::noise_floor);
  visitor.flag("guided", "Compute the first field from the trusted matches", &LafOptions::guided);
  visitor.number({"guide_ratio", 0, 1, "-", "Guided: trusted matches have a distance ratio below this"},
                 &LafOptions::guide_ratio);
  visitConfidence(visitor);
}

void LafOptions::check() const {
  ConfidenceOptions::check();
  if (min_cells > max_cells) {
    throw std::invalid_argument("option min_cells = " + std::to_string(min_cells) +
                                " is above max_cells = " + std::to_string(max_cells));
  }
}

Presets LafSelector::presets() const { return {{"guided", {{"guided", "true"}}}}; }

std::string LafSelector::missingInput(const Correspondences& matches) const {
  return options_.guided ? TrustedSet::missingInput(matches, "laf with guided = true") : "";
}

void LafSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const std::size_t n = matches.size();
  if (n < kMinMatches) {
    result.status = Status::kTooFew;
    result.message = std::to_string(n) + " matches, laf needs " + std::to_string(kMinMatches);
    return;
  }
  if (endsAtEqualPoints(matches, result)) return;
  LafMemory& work = workspace.part<LafMemory>();
  const double min_variance = std::max(kMinVariance, scale(matches, options_.noise_floor, work));
  markUnique(matches, work);
  work.active = work.unique;
  if (options_.guided) {
    work.trusted.find(matches, options_.guide_ratio);
    if (work.trusted.size() >= TrustedSet::kMinMatches) work.active = work.trusted.mask();
  }
  const std::size_t padded = (n + kFieldGroup - 1) / kFieldGroup * kFieldGroup;
  work.squared.assign(padded, 0.0);
  work.posterior.assign(padded, 0.0);
  work.cell.resize(n);
  work.slot.resize(n);
  work.next.resize(n);

  const int cells = std::clamp(static_cast<int>(std::lround(std::sqrt(static_cast<double>(n)))),
                               options_.min_cells, options_.max_cells);
  const int kernel = std::max(1, 2 * static_cast<int>(std::lround(cells / 6.0)) - 1);
  FieldPosteriorRule rule{};
  work.field.start(cells, kernel);
  for (std::size_t i = 0; i < n; ++i) {
    work.cell[i] = work.field.cell(work.x[i], work.y[i]);
    work.slot[i] = work.field.slot(work.cell[i]);
  }
  if (!iterate(options_, n, min_variance, work, rule, result)) return;
  kernels().field.posteriors(rule, work.squared.data(), n, work.posterior.data());
  result.score.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    result.mask[i] = work.posterior[i] > options_.accept ? 1 : 0;
    result.score[i] = static_cast<float>(work.posterior[i]);
  }
}

}  // namespace corrsel::core
