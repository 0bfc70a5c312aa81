#pragma once

// Normal equations of the least-squares problems that refine two-view models, over the inliers only.

#include "kernels/kernels.h"
#include "kernels/residual_kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

/// One row of kLanes matches, the missing ones behind the end filled with NaN, which is no inlier of
/// anything.
struct MatchLanes {
  FloatV x[kParts], y[kParts], u[kParts], v[kParts];
};

inline void loadLanes(const float* column, std::size_t count, FloatV (&out)[kParts]) {
  if (count >= kLanes) {
    for (int p = 0; p < kParts; ++p) out[p] = load(column + p * kWidth);
    return;
  }
  float lanes[kLanes];
  for (int k = 0; k < kLanes; ++k)
    lanes[k] = static_cast<std::size_t>(k) < count ? column[k] : __builtin_nanf("");
  for (int p = 0; p < kParts; ++p) out[p] = load(lanes + p * kWidth);
}

inline void loadLanes(const MatchColumns& m, std::size_t begin, MatchLanes& out) {
  const std::size_t count = m.size - begin;
  loadLanes(m.left_x + begin, count, out.x);
  loadLanes(m.left_y + begin, count, out.y);
  loadLanes(m.right_x + begin, count, out.u);
  loadLanes(m.right_y + begin, count, out.v);
}

inline FloatV keep(IntV mask, FloatV value) { return mask ? value : FloatV{}; }

/// The six products p_i p_j, i <= j, of a vector of three.
inline void products(const FloatV (&p)[3], FloatV (&out)[6]) {
  int k = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) out[k++] = p[i] * p[j];
  }
}

// Terms of the sums of a model: what is computed of a match once (kValues), and the sums in groups that fit
// into the registers of a processor, each with the number of its first sum.

struct TransferTerms {
  static constexpr int kCount = static_cast<int>(kHomographySums), kValues = 9, kGroups = 3;
  static constexpr int kBegins[kGroups + 1] = {0, 12, 24, kCount};

  static inline void prepare(const ResidualModel& model, IntV inlier, FloatV x, FloatV y, FloatV u, FloatV v,
                             FloatV (&values)[kValues]) {
    const float(&h)[9] = model.forward;
    const FloatV inverse = 1.0F / (h[6] * x + h[7] * y + h[8]);
    const FloatV px = (h[0] * x + h[1] * y + h[2]) * inverse, py = (h[3] * x + h[4] * y + h[5]) * inverse;
    const FloatV hx = keep(inlier, px), hy = keep(inlier, py);
    const FloatV dx = keep(inlier, u - px), dy = keep(inlier, v - py);
    values[0] = keep(inlier, x * inverse);
    values[1] = keep(inlier, y * inverse);
    values[2] = keep(inlier, inverse);
    values[3] = hx;
    values[4] = hy;
    values[5] = hx * hx + hy * hy;
    values[6] = dx;
    values[7] = dy;
    values[8] = hx * dx + hy * dy;
  }

  template <int group>
  static inline void add(const FloatV (&values)[kValues], FloatV* sums) {
    const FloatV a[3] = {values[0], values[1], values[2]};
    if constexpr (group == 2) {
      for (int k = 0; k < 3; ++k) {
        sums[k] += values[6] * a[k];
        sums[3 + k] += values[7] * a[k];
        sums[6 + k] += values[8] * a[k];
      }
    } else {
      FloatV aa[6];
      products(a, aa);
      for (int k = 0; k < 6; ++k) {
        sums[k] += group == 0 ? aa[k] : values[4] * aa[k];
        sums[6 + k] += values[group == 0 ? 3 : 5] * aa[k];
      }
    }
  }
};

struct SampsonTerms {
  static constexpr int kCount = static_cast<int>(kFundamentalSums), kValues = 5, kGroups = 3;
  static constexpr int kBegins[kGroups + 1] = {0, 12, 24, kCount};

  static inline void prepare(const ResidualModel& model, IntV inlier, FloatV x, FloatV y, FloatV u, FloatV v,
                             FloatV (&values)[kValues]) {
    const float(&f)[9] = model.forward;
    const FloatV a = f[0] * x + f[1] * y + f[2], b = f[3] * x + f[4] * y + f[5];
    const FloatV c = f[0] * u + f[3] * v + f[6], d = f[1] * u + f[4] * v + f[7];
    values[0] = keep(inlier, 1.0F / (a * a + b * b + c * c + d * d + __FLT_MIN__));
    values[1] = keep(inlier, x);
    values[2] = keep(inlier, y);
    values[3] = keep(inlier, u);
    values[4] = keep(inlier, v);
  }

  template <int group>
  static inline void add(const FloatV (&values)[kValues], FloatV* sums) {
    const FloatV one = splat(1.0F);
    const FloatV left[3] = {values[1], values[2], one}, right[3] = {values[3], values[4], one};
    FloatV ll[6], rr[6];
    products(left, ll);
    products(right, rr);
    for (int i = 0; i < 2; ++i) {
      const FloatV weighted = values[0] * rr[2 * group + i];
      for (int k = 0; k < 6; ++k) sums[6 * i + k] += weighted * ll[k];
    }
  }
};

/// Adds one group of sums of some vectors of matches.
template <class Terms, int group>
inline void addGroup(const FloatV (*values)[Terms::kValues], std::size_t vectors, FloatV (*sums)[kParts],
                     int part) {
  constexpr int kBegin = Terms::kBegins[group], kCount = Terms::kBegins[group + 1] - kBegin;
  FloatV local[kCount];
  for (int k = 0; k < kCount; ++k) local[k] = sums[kBegin + k][part];
  for (std::size_t i = 0; i < vectors; ++i) Terms::template add<group>(values[i], local);
  for (int k = 0; k < kCount; ++k) sums[kBegin + k][part] = local[k];
}

/// Writes what the sums need of up to kVectors rows of lanes, from match `begin` to `end`. Vectors without an
/// inlier, which would add 0 to every sum, are overwritten by the next one, because a branch costs more.
/// @param vectors  receives the number of vectors of each part
template <class R, class Terms, std::size_t kVectors>
inline void prepareRows(const ResidualModel& model, const MatchColumns& m, std::size_t begin, std::size_t end,
                        float squared_threshold, FloatV (&values)[kParts][kVectors][Terms::kValues],
                        std::size_t (&vectors)[kParts]) {
  for (int p = 0; p < kParts; ++p) vectors[p] = 0;
  for (std::size_t row = 0; row < kVectors && begin + row * kLanes < end; ++row) {
    const std::size_t i = begin + row * kLanes;
    MatchLanes lanes;
    loadLanes(m, i, lanes);
    for (int p = 0; p < kParts; ++p) {
      const Fraction<FloatV> error =
          R::template error<FloatV>(model, lanes.x[p], lanes.y[p], lanes.u[p], lanes.v[p]);
      const IntV inlier = error.below(squared_threshold);
      Terms::prepare(model, inlier, lanes.x[p], lanes.y[p], lanes.u[p], lanes.v[p], values[p][vectors[p]]);
      vectors[p] += anyTrue(inlier) ? 1 : 0;
    }
  }
}

template <class R, class Terms>
void normalKernel(const ResidualModel& model, const MatchColumns& m, float squared_threshold, double* out) {
  constexpr std::size_t kBlock = 1024;  // then the single precision sums are added to double precision ones
  constexpr std::size_t kStep = 256, kVectors = kStep / kLanes;  // matches whose values are kept at a time
  for (int k = 0; k < Terms::kCount; ++k) out[k] = 0;
  for (std::size_t begin = 0; begin < m.size; begin += kBlock) {
    FloatV sums[Terms::kCount][kParts] = {};
    const std::size_t end = begin + kBlock < m.size ? begin + kBlock : m.size;
    for (std::size_t step = begin; step < end; step += kStep) {
      FloatV values[kParts][kVectors][Terms::kValues];
      std::size_t vectors[kParts];
      prepareRows<R, Terms>(model, m, step, end, squared_threshold, values, vectors);
      for (int p = 0; p < kParts; ++p) {
        addGroup<Terms, 0>(values[p], vectors[p], sums, p);
        addGroup<Terms, 1>(values[p], vectors[p], sums, p);
        addGroup<Terms, 2>(values[p], vectors[p], sums, p);
      }
    }
    for (int k = 0; k < Terms::kCount; ++k) {
      for (int lane = 0; lane < kLanes; ++lane)
        out[k] += static_cast<double>(sums[k][lane / kWidth][lane % kWidth]);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
