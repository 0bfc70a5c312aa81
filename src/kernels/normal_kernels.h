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

struct TransferTerms {
  static constexpr int kCount = static_cast<int>(kHomographySums);

  static inline void add(const ResidualModel& model, IntV inlier, FloatV x, FloatV y, FloatV u, FloatV v,
                         FloatV (&sums)[kCount][kParts], int part) {
    const float(&h)[9] = model.forward;
    const FloatV inverse = 1.0F / (h[6] * x + h[7] * y + h[8]);
    const FloatV px = (h[0] * x + h[1] * y + h[2]) * inverse, py = (h[3] * x + h[4] * y + h[5]) * inverse;
    const FloatV a[3] = {keep(inlier, x * inverse), keep(inlier, y * inverse), keep(inlier, inverse)};
    const FloatV hx = keep(inlier, px), hy = keep(inlier, py);
    const FloatV dx = keep(inlier, u - px), dy = keep(inlier, v - py);
    const FloatV squared = hx * hx + hy * hy, turned = hx * dx + hy * dy;
    FloatV aa[6];
    products(a, aa);
    for (int k = 0; k < 6; ++k) {
      sums[k][part] += aa[k];
      sums[6 + k][part] += hx * aa[k];
      sums[12 + k][part] += hy * aa[k];
      sums[18 + k][part] += squared * aa[k];
    }
    for (int k = 0; k < 3; ++k) {
      sums[24 + k][part] += dx * a[k];
      sums[27 + k][part] += dy * a[k];
      sums[30 + k][part] += turned * a[k];
    }
  }
};

struct SampsonTerms {
  static constexpr int kCount = static_cast<int>(kFundamentalSums);

  static inline void add(const ResidualModel& model, IntV inlier, FloatV x, FloatV y, FloatV u, FloatV v,
                         FloatV (&sums)[kCount][kParts], int part) {
    const float(&f)[9] = model.forward;
    const FloatV a = f[0] * x + f[1] * y + f[2], b = f[3] * x + f[4] * y + f[5];
    const FloatV c = f[0] * u + f[3] * v + f[6], d = f[1] * u + f[4] * v + f[7];
    const FloatV weight = keep(inlier, 1.0F / (a * a + b * b + c * c + d * d + __FLT_MIN__));
    const FloatV one = splat(1.0F);
    const FloatV left[3] = {keep(inlier, x), keep(inlier, y), one};
    const FloatV right[3] = {keep(inlier, u), keep(inlier, v), one};
    FloatV ll[6], rr[6];
    products(left, ll);
    products(right, rr);
    for (int i = 0; i < 6; ++i) {
      const FloatV weighted = weight * rr[i];
      for (int k = 0; k < 6; ++k) sums[6 * i + k][part] += weighted * ll[k];
    }
  }
};

template <class R, class Terms>
void normalKernel(const ResidualModel& model, const MatchColumns& m, float squared_threshold, double* out) {
  constexpr std::size_t kBlock = 1024;  // then the single precision sums are added to double precision ones
  for (int k = 0; k < Terms::kCount; ++k) out[k] = 0;
  for (std::size_t begin = 0; begin < m.size; begin += kBlock) {
    FloatV sums[Terms::kCount][kParts] = {};
    const std::size_t end = begin + kBlock < m.size ? begin + kBlock : m.size;
    for (std::size_t i = begin; i < end; i += kLanes) {
      MatchLanes lanes;
      loadLanes(m, i, lanes);
      for (int p = 0; p < kParts; ++p) {
        const Fraction<FloatV> error =
            R::template error<FloatV>(model, lanes.x[p], lanes.y[p], lanes.u[p], lanes.v[p]);
        const IntV inlier = error.below(squared_threshold);
        Terms::add(model, inlier, lanes.x[p], lanes.y[p], lanes.u[p], lanes.v[p], sums, p);
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
