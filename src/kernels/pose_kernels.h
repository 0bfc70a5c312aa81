#pragma once

// Errors of relative poses between unit rays, in double precision. Matches come in rows of kGroup, of which
// match k adds to lane k of a sum.

#include "kernels/field_kernels.h"
#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

constexpr double kMinGradient = 1e-30;  // keeps errors finite where both gradients vanish

/// A row that the matches do not fill: the missing ones have rays of length 0, which add 0 to every sum.
struct LastRow {
  double values[2][MatchRays::kColumns][kGroup];
  MatchRays columns;

  LastRow(const MatchRays& m, std::size_t begin, std::size_t end) {
    for (std::size_t c = 0; c < MatchRays::kColumns; ++c) {
      for (std::size_t k = 0; k < kGroup; ++k) {
        values[0][c][k] = begin + k < end ? m.left[c][begin + k] : 0.0;
        values[1][c][k] = begin + k < end ? m.right[c][begin + k] : 0.0;
      }
      columns.left[c] = values[0][c];
      columns.right[c] = values[1][c];
    }
    columns.size = kGroup;
  }
};

struct Vector3 {
  DoubleV x, y, z;
};

inline Vector3 directionAt(const double* const (&columns)[MatchRays::kColumns], std::size_t i) {
  return {load(columns[0] + i), load(columns[1] + i), load(columns[2] + i)};
}

inline DoubleV dot(const double* row, const Vector3& v) { return row[0] * v.x + row[1] * v.y + row[2] * v.z; }

/// M v of a row-major matrix.
inline Vector3 product(const double* m, const Vector3& v) {
  return {dot(m, v), dot(m + 3, v), dot(m + 6, v)};
}

/// M^T v
inline Vector3 transposedProduct(const double* m, const Vector3& v) {
  return {m[0] * v.x + m[3] * v.y + m[6] * v.z, m[1] * v.x + m[4] * v.y + m[7] * v.z,
          m[2] * v.x + m[5] * v.y + m[8] * v.z};
}

/// Numbers by the two coordinates of a pixel.
struct Pair {
  DoubleV x, y;
};

/// J^T v with the 3x2 Jacobian in columns 3 to 8.
inline Pair gradientAt(const double* const (&columns)[MatchRays::kColumns], std::size_t i, const Vector3& v) {
  return {load(columns[3] + i) * v.x + load(columns[5] + i) * v.y + load(columns[7] + i) * v.z,
          load(columns[4] + i) * v.x + load(columns[6] + i) * v.y + load(columns[8] + i) * v.z};
}

/// J p
inline Vector3 displacementAt(const double* const (&columns)[MatchRays::kColumns], std::size_t i,
                              const Pair& p) {
  return {load(columns[3] + i) * p.x + load(columns[4] + i) * p.y,
          load(columns[5] + i) * p.x + load(columns[6] + i) * p.y,
          load(columns[7] + i) * p.x + load(columns[8] + i) * p.y};
}

inline DoubleV squaredGradient(const Pair& p, const Pair& q) {
  return (p.x * p.x + p.y * p.y) + (q.x * q.x + q.y * q.y) + kMinGradient;
}

/// Squared errors of one row.
inline void errorRow(const double* essential, const MatchRays& m, std::size_t begin, double* out) {
  for (std::size_t part = 0; part < kGroupParts; ++part) {
    const std::size_t at = part * kDoubleWidth, i = begin + at;
    const Vector3 right = directionAt(m.right, i);
    const Vector3 l = product(essential, directionAt(m.left, i));
    const Pair p = gradientAt(m.left, i, transposedProduct(essential, right)), q = gradientAt(m.right, i, l);
    const DoubleV c = right.x * l.x + right.y * l.y + right.z * l.z;
    store(out + at, c * c / squaredGradient(p, q));
  }
}

void poseErrorsKernel(const double* essential, const MatchRays& m, std::size_t begin, std::size_t end,
                      double* out) {
  std::size_t i = begin;
  for (; i + kGroup <= end; i += kGroup) errorRow(essential, m, i, out + (i - begin));
  if (i == end) return;
  const LastRow last(m, i, end);
  double errors[kGroup];
  errorRow(essential, last.columns, 0, errors);
  for (std::size_t k = 0; i + k < end; ++k) out[i - begin + k] = errors[k];
}

/// v of kPoseSums, and the loss.
struct PoseTerms {
  DoubleV v[6], loss;
};

/// The terms of kDoubleWidth matches. With a = R d, e = d' in the basis, in which t is the third axis, C =
/// e_y a_x - e_x a_y. k = C / D of the squared gradient D, g = a - k R J p, h = k J' q, in the basis too: r
/// changes by (g x (e x t) - a x (h x t)) / sqrt(D) with the rotation, by (g x e - a x h) / sqrt(D) with t.
inline PoseTerms termsAt(const PoseInBasis& pose, const MatchRays& m, double inverse_squared_scale,
                         std::size_t i) {
  const double *const basis = pose.basis, *const rotation = pose.rotation;
  const Vector3 left = directionAt(m.left, i);
  const Vector3 a = product(rotation, left), e = product(basis, directionAt(m.right, i));
  const Pair p = gradientAt(m.left, i,
                            {rotation[0] * e.y - rotation[3] * e.x, rotation[1] * e.y - rotation[4] * e.x,
                             rotation[2] * e.y - rotation[5] * e.x});
  const Pair q = gradientAt(
      m.right, i,
      {basis[3] * a.x - basis[0] * a.y, basis[4] * a.x - basis[1] * a.y, basis[5] * a.x - basis[2] * a.y});
  const DoubleV c = e.y * a.x - e.x * a.y, d = squaredGradient(p, q);
  // One division for both 1 / D and the square root of the weight, 1 / (1 + C^2 / (D c^2)).
  const DoubleV sum = d + c * c * inverse_squared_scale, reciprocal = 1.0 / (d * sum);
  const DoubleV inverse = sum * reciprocal, root_weight = d * d * reciprocal;
  const DoubleV root = squareRoot(inverse), k = c * inverse, factor = root_weight * root;
  const Vector3 along = displacementAt(m.left, i, {k * p.x, k * p.y});
  const Vector3 g = product(rotation, {left.x - along.x, left.y - along.y, left.z - along.z});
  const Vector3 h = product(basis, displacementAt(m.right, i, {k * q.x, k * q.y}));
  const DoubleV r = c * root;
  PoseTerms terms;
  terms.v[0] = factor * (e.x * g.z - h.x * a.z);
  terms.v[1] = factor * (e.y * g.z - h.y * a.z);
  terms.v[2] = factor * ((a.x * h.x + a.y * h.y) - (g.x * e.x + g.y * e.y));
  terms.v[3] = factor * ((g.y * e.z - g.z * e.y) - (a.y * h.z - a.z * h.y));
  terms.v[4] = factor * ((g.z * e.x - g.x * e.z) - (a.z * h.x - a.x * h.z));
  terms.v[5] = root_weight * r;
  terms.loss = r * terms.v[5];
  return terms;
}

/// Adds v_i v_j of some vectors of matches for i of [begin, end), in as many sums as fit into registers.
template <int begin, int end, int count>
inline void addPoseTerms(const PoseTerms* terms, std::size_t vectors, DoubleV* sums) {
  DoubleV local[count];
  for (int k = 0; k < count; ++k) local[k] = sums[k];
  for (std::size_t n = 0; n < vectors; ++n) {
    const PoseTerms& t = terms[n];
    int k = 0;
    for (int i = begin; i < end; ++i) {
      for (int j = i; j < 6; ++j) local[k++] += i < 5 ? t.v[i] * t.v[j] : t.loss;
    }
  }
  for (int k = 0; k < count; ++k) sums[k] = local[k];
}

void poseSumsKernel(const PoseInBasis& pose, const MatchRays& m, double inverse_squared_scale, double* out) {
  constexpr std::size_t kRows = 16;  // whose terms are kept at a time
  constexpr int kFirst = 11;         // sums of the first two terms
  DoubleV sums[kGroupParts][kPoseSums] = {};
  const std::size_t whole = m.size - m.size % kGroup;
  for (std::size_t begin = 0; begin < m.size; begin += kRows * kGroup) {
    PoseTerms terms[kGroupParts][kRows];
    std::size_t rows = 0;
    for (std::size_t i = begin; i < whole && rows < kRows; i += kGroup, ++rows) {
      for (std::size_t part = 0; part < kGroupParts; ++part)
        terms[part][rows] = termsAt(pose, m, inverse_squared_scale, i + part * kDoubleWidth);
    }
    if (rows < kRows && whole < m.size) {
      const LastRow last(m, whole, m.size);
      for (std::size_t part = 0; part < kGroupParts; ++part)
        terms[part][rows] = termsAt(pose, last.columns, inverse_squared_scale, part * kDoubleWidth);
      ++rows;
    }
    for (std::size_t part = 0; part < kGroupParts; ++part) {
      addPoseTerms<0, 2, kFirst>(terms[part], rows, sums[part]);
      addPoseTerms<2, 6, static_cast<int>(kPoseSums) - kFirst>(terms[part], rows, sums[part] + kFirst);
    }
  }
  for (std::size_t k = 0; k < kPoseSums; ++k) {
    double lane[kGroup];
    for (std::size_t part = 0; part < kGroupParts; ++part) store(lane + part * kDoubleWidth, sums[part][k]);
    out[k] = totalOf(lane);
  }
}

/// Lanes are 1 or 0.
struct Sides {
  LongV front, reversed;
};

inline Sides sidesAt(const PoseInBasis& pose, const MatchRays& m, std::size_t i) {
  const Vector3 a = product(pose.rotation, directionAt(m.left, i));
  const Vector3 e = product(pose.basis, directionAt(m.right, i));
  const DoubleV cosine = a.x * e.x + a.y * e.y + a.z * e.z;
  const DoubleV left = cosine * e.z - a.z, right = e.z - cosine * a.z;
  return {-((left > 0.0) & (right > 0.0)), -((left < 0.0) & (right < 0.0))};
}

SideCounts poseSidesKernel(const PoseInBasis& pose, const MatchRays& m) {
  LongV front{}, reversed{};
  const auto add = [&](const MatchRays& columns, std::size_t i) {
    for (std::size_t part = 0; part < kGroupParts; ++part) {
      const Sides sides = sidesAt(pose, columns, i + part * kDoubleWidth);
      front += sides.front;
      reversed += sides.reversed;
    }
  };
  const std::size_t whole = m.size - m.size % kGroup;
  for (std::size_t i = 0; i < whole; i += kGroup) add(m, i);
  if (whole < m.size) {
    const LastRow last(m, whole, m.size);
    add(last.columns, 0);
  }
  SideCounts counts{0, 0};
  for (int k = 0; k < kDoubleWidth; ++k) {
    counts.front += static_cast<std::size_t>(front[k]);
    counts.reversed += static_cast<std::size_t>(reversed[k]);
  }
  return counts;
}

}  // namespace
}  // namespace corrsel::core
