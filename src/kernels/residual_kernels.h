#pragma once

// Errors and scores of two-view models. T is float or FloatV throughout: both round alike.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

inline IntV both(IntV a, IntV b) { return a & b; }
inline bool both(bool a, bool b) { return a && b; }

/// A squared error as a fraction, which can be compared with a threshold without a division.
template <class T>
struct Fraction {
  T numerator, denominator;
  decltype(T{} > T{}) exists;  // whether the point lies before the cameras

  decltype(T{} > T{}) below(float threshold) const {
    return both(numerator <= threshold * denominator, exists);
  }
  T value() const { return exists ? numerator / denominator : __builtin_inff() - T{}; }
};

/// Squared distance of (u, v) from the image of (x, y), which must not lie behind the camera or at infinity.
template <class T>
inline Fraction<T> transferError(const float (&h)[9], T x, T y, T u, T v) {
  constexpr float kInfinitelyFar = 1e-9F;  // third coordinate, coordinates and H being about 1
  const T w = h[6] * x + h[7] * y + h[8];
  const T dx = h[0] * x + h[1] * y + h[2] - u * w;
  const T dy = h[3] * x + h[4] * y + h[5] - v * w;
  return {dx * dx + dy * dy, w * w, w > kInfinitelyFar};
}

struct Transfer {
  template <class T>
  static Fraction<T> error(const ResidualModel& model, T x, T y, T u, T v) {
    return transferError(model.forward, x, y, u, v);
  }
};

struct SymmetricTransfer {
  template <class T>
  static Fraction<T> error(const ResidualModel& model, T x, T y, T u, T v) {
    const Fraction<T> there = transferError(model.forward, x, y, u, v);
    const Fraction<T> back = transferError(model.backward, u, v, x, y);
    return {there.numerator * back.denominator + back.numerator * there.denominator,
            there.denominator * back.denominator, both(there.exists, back.exists)};
  }
};

struct SmallerTransfer {
  template <class T>
  static Fraction<T> error(const ResidualModel& model, T x, T y, T u, T v) {
    const Fraction<T> there = transferError(model.forward, x, y, u, v);
    const Fraction<T> back = transferError(model.backward, u, v, x, y);
    const auto forward = there.numerator * back.denominator <= back.numerator * there.denominator;
    return {forward ? there.numerator : back.numerator, forward ? there.denominator : back.denominator,
            both(there.exists, back.exists)};
  }
};

struct Sampson {
  template <class T>
  static Fraction<T> error(const ResidualModel& model, T x, T y, T u, T v) {
    const float(&f)[9] = model.forward;
    const T a = f[0] * x + f[1] * y + f[2], b = f[3] * x + f[4] * y + f[5];
    const T c = f[0] * u + f[3] * v + f[6], d = f[1] * u + f[4] * v + f[7];
    const T residual = u * a + v * b + f[6] * x + f[7] * y + f[8];
    const T gradient = a * a + b * b + c * c + d * d + __FLT_MIN__;
    return {residual * residual, gradient, gradient > 0.0F};
  }
};

/// The error of rays, whose numbers are read by their place, so that lanes and single matches share it.
struct TangentSampson {
  template <class T, class Left, class Right>
  static Fraction<T> error(const ResidualModel& model, const Left& left, const Right& right) {
    const float(&e)[9] = model.forward;
    const T x = left(0), y = left(1), z = left(2), u = right(0), v = right(1), w = right(2);
    const T l0 = e[0] * x + e[1] * y + e[2] * z, l1 = e[3] * x + e[4] * y + e[5] * z,
            l2 = e[6] * x + e[7] * y + e[8] * z;
    const T m0 = e[0] * u + e[3] * v + e[6] * w, m1 = e[1] * u + e[4] * v + e[7] * w,
            m2 = e[2] * u + e[5] * v + e[8] * w;
    const T residual = u * l0 + v * l1 + w * l2;
    const T a = left(3) * m0 + left(5) * m1 + left(7) * m2, b = left(4) * m0 + left(6) * m1 + left(8) * m2;
    const T c = right(3) * l0 + right(5) * l1 + right(7) * l2,
            d = right(4) * l0 + right(6) * l1 + right(8) * l2;
    const T gradient = a * a + b * b + c * c + d * d + __FLT_MIN__;
    return {residual * residual, gradient, gradient > 0.0F};
  }
};

template <class R>
inline Fraction<FloatV> errorAt(const ResidualModel& model, const MatchColumns& m, std::size_t i) {
  return R::template error<FloatV>(model, load(m.left_x + i), load(m.left_y + i), load(m.right_x + i),
                                   load(m.right_y + i));
}

template <>
inline Fraction<FloatV> errorAt<TangentSampson>(const ResidualModel& model, const MatchColumns& m,
                                                std::size_t i) {
  return TangentSampson::error<FloatV>(
      model, [&](std::size_t k) { return load(m.left_rays + k * m.ray_stride + i); },
      [&](std::size_t k) { return load(m.right_rays + k * m.ray_stride + i); });
}

template <class R>
inline Fraction<float> scalarErrorAt(const ResidualModel& model, const MatchColumns& m, std::size_t i) {
  return R::template error<float>(model, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
}

template <>
inline Fraction<float> scalarErrorAt<TangentSampson>(const ResidualModel& model, const MatchColumns& m,
                                                     std::size_t i) {
  return TangentSampson::error<float>(
      model, [&](std::size_t k) { return m.left_rays[k * m.ray_stride + i]; },
      [&](std::size_t k) { return m.right_rays[k * m.ray_stride + i]; });
}

template <class R>
void errorsKernel(const ResidualModel& model, const MatchColumns& m, std::size_t begin, std::size_t end,
                  float* out) {
  std::size_t i = begin;
  for (; i + kWidth <= end; i += kWidth) store(out + (i - begin), errorAt<R>(model, m, i).value());
  for (; i < end; ++i) out[i - begin] = scalarErrorAt<R>(model, m, i).value();
}

/// Adds matches [begin, end), fewer than 2^14, to the score.
template <class R>
inline void addBlock(const ResidualModel& model, const MatchColumns& m, const ScoreRule& rule,
                     std::size_t begin, std::size_t end, ModelScore& score) {
  std::size_t i = begin;
  IntV saved{}, count{};
  bool any = false;
  for (; i + kWidth <= end; i += kWidth) {
    const Fraction<FloatV> error = errorAt<R>(model, m, i);
    const IntV inlier = error.below(rule.squared_threshold);
    if (!anyTrue(inlier)) continue;  // the rule for a bad model
    any = true;
    count -= inlier;  // a set lane is -1
    const FloatV cost = error.numerator / error.denominator * rule.cost_per_error;
    saved += inlier ? ScoreRule::kOutlierCost - truncate(inlier ? cost : FloatV{}) : IntV{};
  }
  std::int32_t inliers = any ? sum(count) : 0, saved_sum = any ? sum(saved) : 0;
  for (; i < end; ++i) {
    const Fraction<float> error = scalarErrorAt<R>(model, m, i);
    if (!error.below(rule.squared_threshold)) continue;
    ++inliers;
    saved_sum +=
        ScoreRule::kOutlierCost - truncate(error.numerator / error.denominator * rule.cost_per_error);
  }
  score.cost += static_cast<std::int64_t>(end - begin) * ScoreRule::kOutlierCost - saved_sum;
  score.inliers += static_cast<std::size_t>(inliers);
  score.seen += end - begin;
}

inline double asDouble(std::size_t count) { return static_cast<double>(static_cast<std::int64_t>(count)); }

/// The SPRT's verdict on the matches that the score has seen.
inline bool rejectsBySprt(const ScoreRule& rule, const ModelScore& score) {
  return asDouble(score.inliers) * rule.log_consistent +
             asDouble(score.seen - score.inliers) * rule.log_inconsistent >
         rule.log_decision;
}

/// Whether the cost has reached the limit, or almost surely will.
inline bool isTooHigh(const ScoreRule& rule, std::size_t matches, const ModelScore& score) {
  const double seen = asDouble(score.seen);
  const double excess =
      static_cast<double>(score.cost) - static_cast<double>(rule.limit) * (seen / asDouble(matches));
  return score.cost >= rule.limit || (excess > 0 && excess * excess > rule.squared_margin * seen);
}

template <class R>
ModelScore scoreKernel(const ResidualModel& model, const MatchColumns& m, const ScoreRule& rule) {
  constexpr std::size_t kLongBlock = 128;
  ModelScore score;
  const bool sprt = rule.log_consistent != 0 || rule.log_inconsistent != 0;
  const std::size_t step = sprt ? ScoreRule::kBlock : kLongBlock;
  const std::size_t start = rule.start < m.size ? rule.start : 0;
  const std::size_t ranges[2][2] = {{start, m.size}, {0, start}};
  for (const auto& range : ranges) {
    for (std::size_t begin = range[0]; begin < range[1]; begin += kLongBlock) {
      const std::size_t end = begin + kLongBlock < range[1] ? begin + kLongBlock : range[1];
      for (std::size_t i = begin; i < end; i += step) {
        addBlock<R>(model, m, rule, i, i + step < end ? i + step : end, score);
        score.rejected = score.rejected_by_sprt = sprt && rejectsBySprt(rule, score);
        if (score.rejected) return score;
      }
      score.rejected = isTooHigh(rule, m.size, score);
      if (score.rejected) return score;
    }
  }
  return score;
}

}  // namespace
}  // namespace corrsel::core
