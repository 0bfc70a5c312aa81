#pragma once

// Errors and scores of two-view models. T is float or FloatV throughout: both round alike.

#include "corrsel/kernels/kernels.h"
#include "simd.h"

namespace corrsel::core {
namespace {

constexpr float kInfinity = __builtin_inff();

/// Squared distance of (u, v) from the image of (x, y); +Inf where that lies behind the camera.
template <class T>
inline T transferError(const float (&h)[9], T x, T y, T u, T v) {
  const T w = h[6] * x + h[7] * y + h[8];
  const T inverse = 1.0F / w;
  const T dx = (h[0] * x + h[1] * y + h[2]) * inverse - u;
  const T dy = (h[3] * x + h[4] * y + h[5]) * inverse - v;
  const T squared = dx * dx + dy * dy;
  return w > 0.0F ? squared : kInfinity - T{};
}

struct Transfer {
  template <class T>
  static T error(const ResidualModel& model, T x, T y, T u, T v) {
    return transferError(model.forward, x, y, u, v);
  }
};

struct SymmetricTransfer {
  template <class T>
  static T error(const ResidualModel& model, T x, T y, T u, T v) {
    return transferError(model.forward, x, y, u, v) + transferError(model.backward, u, v, x, y);
  }
};

struct Sampson {
  template <class T>
  static T error(const ResidualModel& model, T x, T y, T u, T v) {
    const float(&f)[9] = model.forward;
    const T a = f[0] * x + f[1] * y + f[2], b = f[3] * x + f[4] * y + f[5];
    const T c = f[0] * u + f[3] * v + f[6], d = f[1] * u + f[4] * v + f[7];
    const T residual = u * a + v * b + f[6] * x + f[7] * y + f[8];
    return residual * residual / (a * a + b * b + c * c + d * d + __FLT_MIN__);
  }
};

template <class R>
void errorsKernel(const ResidualModel& model, const MatchColumns& m, std::size_t begin, std::size_t end,
                  float* out) {
  std::size_t i = begin;
  for (; i + kWidth <= end; i += kWidth) {
    store(out + (i - begin), R::template error<FloatV>(model, load(m.left_x + i), load(m.left_y + i),
                                                       load(m.right_x + i), load(m.right_y + i)));
  }
  for (; i < end; ++i)
    out[i - begin] = R::template error<float>(model, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
}

/// Adds matches [begin, end), fewer than 2^14, to the score.
template <class R>
inline void addBlock(const ResidualModel& model, const MatchColumns& m, const ScoreRule& rule,
                     std::size_t begin, std::size_t end, ModelScore& score) {
  std::size_t i = begin;
  IntV cost{};
  std::uint32_t inliers = 0;
  for (; i + kWidth <= end; i += kWidth) {
    const FloatV error = R::template error<FloatV>(model, load(m.left_x + i), load(m.left_y + i),
                                                   load(m.right_x + i), load(m.right_y + i));
    const IntV inlier = error <= rule.squared_threshold;
    inliers += countTrue(inlier);
    cost +=
        inlier ? truncate(inlier ? error * rule.cost_per_error : FloatV{}) : splat(ScoreRule::kOutlierCost);
  }
  score.cost += sum(cost);
  for (; i < end; ++i) {
    const float error = R::template error<float>(model, m.left_x[i], m.left_y[i], m.right_x[i], m.right_y[i]);
    const bool inlier = error <= rule.squared_threshold;
    inliers += countTrue(inlier);
    score.cost += inlier ? truncate(error * rule.cost_per_error) : ScoreRule::kOutlierCost;
  }
  score.inliers += inliers;
  score.seen += end - begin;
}

/// Scores matches [begin, end). @return false where the model is rejected.
template <class R, std::size_t kStep>
inline bool addRange(const ResidualModel& model, const MatchColumns& m, const ScoreRule& rule,
                     std::size_t begin, std::size_t end, ModelScore& score) {
  for (std::size_t i = begin; i < end; i += kStep) {
    addBlock<R>(model, m, rule, i, i + kStep < end ? i + kStep : end, score);
    if (kStep == ScoreRule::kBlock) {
      const double log_ratio = static_cast<double>(score.inliers) * rule.log_consistent +
                               static_cast<double>(score.seen - score.inliers) * rule.log_inconsistent;
      score.rejected_by_sprt = log_ratio > rule.log_decision;
    }
    score.rejected = score.rejected_by_sprt || score.cost >= rule.limit;
    if (score.rejected) return false;
  }
  return true;
}

template <class R>
ModelScore scoreKernel(const ResidualModel& model, const MatchColumns& m, const ScoreRule& rule) {
  ModelScore score;
  const bool sprt = rule.log_consistent != 0 || rule.log_inconsistent != 0;
  const std::size_t start = rule.start < m.size ? rule.start : 0;
  if (sprt) {
    if (addRange<R, ScoreRule::kBlock>(model, m, rule, start, m.size, score))
      addRange<R, ScoreRule::kBlock>(model, m, rule, 0, start, score);
  } else if (addRange<R, 256>(model, m, rule, start, m.size, score)) {
    addRange<R, 256>(model, m, rule, 0, start, score);
  }
  return score;
}

}  // namespace
}  // namespace corrsel::core
