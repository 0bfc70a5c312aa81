#pragma once

// The five-point problem for eight samples at a time. Up to the polynomial of degree 10, a lane is a sample,
// and there is neither pivoting nor branching. After that a lane is an angle or a root. Every lane goes
// through the same operations in the same order whatever the width.
// The equations are those of Nister, PAMI 2004, and Stewenius, Engels and Nister, ISPRS 2006.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

/// What the steps hand on, one column per sample.
struct FivePointState {
  alignas(64) double basis[4][9][kFivePointBatch];  ///< null space of the five equations
  double cubic[3][13][kFivePointBatch];    ///< rows of B(z): x (4 powers of z, ascending), y (4) and 1 (5)
  double polynomial[11][kFivePointBatch];  ///< det B(z), ascending
  double folded[11][kFivePointBatch];      ///< see fold()
};

// ---- Linear algebra on columns whose elements are vectors of samples ----

/// The product of two columns from row `begin` on. Two sums are added up in turn, which takes half as long.
template <int begin, int rows>
inline DoubleV dot(const DoubleV* a, const DoubleV* b) {
  DoubleV even = a[begin] * b[begin], odd = a[begin + 1] * b[begin + 1];
#pragma GCC unroll 10
  for (int i = begin + 2; i < rows; i += 2) even += a[i] * b[i];
#pragma GCC unroll 10
  for (int i = begin + 3; i < rows; i += 2) odd += a[i] * b[i];
  return even + odd;
}

/// Turns x[begin..rows) into the vector v of the Householder reflection I - beta v v^T that maps it to a
/// multiple of the first unit vector.
/// @param diagonal  receives that multiple
/// @return -beta; v is 0 where x is 0
template <int begin, int rows>
inline DoubleV makeReflection(DoubleV* x, DoubleV& diagonal) {
  const DoubleV norm = squareRoot(dot<begin, rows>(x, x)), first = x[begin];
  const LongV sign = (LongV)first & (LongV)(-0.0 - DoubleV{});
  const DoubleV signed_norm = (DoubleV)((LongV)norm | sign);
  x[begin] = first + signed_norm;
  diagonal = -signed_norm;
  return -1.0 / (norm * (norm + absolute(first)) + 1e-290);
}

/// Reflects rows [first_used, rows) of the column a.
/// @param factor  -beta
template <int begin, int rows, int first_used = begin>
inline void reflect(const DoubleV* v, DoubleV factor, DoubleV* a) {
  const DoubleV product = factor * dot<begin, rows>(v, a);
#pragma GCC unroll 10
  for (int i = first_used; i < rows; ++i) a[i] += product * v[i];
}

/// The same for two columns in turn, so that neither has to wait for its own sums.
template <int begin, int rows, int first_used = begin>
inline void reflectTwo(const DoubleV* v, DoubleV factor, DoubleV* a, DoubleV* b) {
  DoubleV even_a = v[begin] * a[begin], odd_a = v[begin + 1] * a[begin + 1];
  DoubleV even_b = v[begin] * b[begin], odd_b = v[begin + 1] * b[begin + 1];
#pragma GCC unroll 10
  for (int i = begin + 2; i < rows; ++i) {
    DoubleV& sum_a = (i - begin) % 2 == 0 ? even_a : odd_a;
    DoubleV& sum_b = (i - begin) % 2 == 0 ? even_b : odd_b;
    sum_a += v[i] * a[i];
    sum_b += v[i] * b[i];
  }
  const DoubleV product_a = factor * (even_a + odd_a), product_b = factor * (even_b + odd_b);
#pragma GCC unroll 10
  for (int i = first_used; i < rows; ++i) {
    const DoubleV vi = v[i], ai = a[i] + product_a * vi, bi = b[i] + product_b * vi;
    a[i] = ai;
    b[i] = bi;
  }
}

/// Reflects a column whose row `begin` is 0.
template <int begin, int rows>
inline void extend(const DoubleV* v, DoubleV factor, DoubleV* a) {
  const DoubleV product = factor * dot<begin + 1, rows>(v, a);
  a[begin] = product * v[begin];
#pragma GCC unroll 10
  for (int i = begin + 1; i < rows; ++i) a[i] += product * v[i];
}

// ---- The null space of the five equations ----

/// The five rows (d'_i d_j) as columns.
inline void writeEquations(const FivePointRays& rays, int lane, DoubleV (&columns)[5][9]) {
  for (int k = 0; k < 5; ++k) {
    for (int i = 0; i < 3; ++i) {
      const DoubleV right = load(rays.right[k][i] + lane);
      for (int j = 0; j < 3; ++j) columns[k][3 * i + j] = right * load(rays.left[k][j] + lane);
    }
  }
}

/// Triangularises columns [k, 5). The next reflection is computed before the other columns are reflected,
/// because its root and quotient take long.
template <int k>
inline void triangulateEquations(DoubleV (&columns)[5][9], DoubleV (&factor)[5]) {
  if constexpr (k < 4) {
    DoubleV diagonal;
    reflect<k, 9, k + 1>(columns[k], factor[k], columns[k + 1]);
    factor[k + 1] = makeReflection<k + 1, 9>(columns[k + 1], diagonal);
    for (int c = k + 2; c < 5; ++c) reflect<k, 9, k + 1>(columns[k], factor[k], columns[c]);
    triangulateEquations<k + 1>(columns, factor);
  }
}

/// An orthonormal basis of the null space. The last entry of E comes first and is multiplied by x: it is
/// small for narrow cameras, and with it as z or 1 the roots would crowd at infinity.
inline void writeBasis(const FivePointRays& rays, int lane, DoubleV (&basis)[4][9]) {
  constexpr int kEntry[4] = {8, 5, 6, 7};
  DoubleV columns[5][9], factor[5], diagonal;
  writeEquations(rays, lane, columns);
  factor[0] = makeReflection<0, 9>(columns[0], diagonal);
  triangulateEquations<0>(columns, factor);
  for (int b = 0; b < 4; ++b) {
    // The last reflection of a unit vector.
    const DoubleV product = factor[4] * columns[4][kEntry[b]];
    DoubleV y[9];
    for (int i = 4; i < 9; ++i) y[i] = product * columns[4][i] + (i == kEntry[b] ? 1.0 : 0.0);
    extend<3, 9>(columns[3], factor[3], y);
    extend<2, 9>(columns[2], factor[2], y);
    extend<1, 9>(columns[1], factor[1], y);
    extend<0, 9>(columns[0], factor[0], y);
#pragma GCC unroll 9
    for (int i = 0; i < 9; ++i) basis[b][i] = y[i];
  }
}

// ---- The ten cubic equations ----

/// Numbers of the monomials of x, y, z, 1 of degree 2 and 3. The right half of the cubic ones, from 10 on,
/// has no power of x and y above the first.
struct Monomials {
  int square[4][4] = {{0, 1, 2, 3}, {1, 4, 5, 6}, {2, 5, 7, 8}, {3, 6, 8, 9}};
  int terms[20] = {};  ///< products of a monomial of degree 2 and one of degree 1, for each cubic one
  int quadratic[20][3] = {}, linear[20][3] = {};  ///< their factors

  constexpr Monomials() {
    // Powers of x, y, z of x3 y3 x2y xy2 x2z x2 y2z y2 xyz xy, xz2 xz x yz2 yz y z3 z2 z 1.
    constexpr int kPowers[20][3] = {{3, 0, 0}, {0, 3, 0}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1},
                                    {2, 0, 0}, {0, 2, 1}, {0, 2, 0}, {1, 1, 1}, {1, 1, 0},
                                    {1, 0, 2}, {1, 0, 1}, {1, 0, 0}, {0, 1, 2}, {0, 1, 1},
                                    {0, 1, 0}, {0, 0, 3}, {0, 0, 2}, {0, 0, 1}, {0, 0, 0}};
    for (int m = 0; m < 20; ++m) {
      for (int i = 0; i < 4; ++i) {
        for (int j = i; j < 4; ++j) {
          for (int k = 0; k < 4; ++k) {
            int power[4] = {};
            ++power[i];
            ++power[j];
            ++power[k];
            if (power[0] != kPowers[m][0] || power[1] != kPowers[m][1] || power[2] != kPowers[m][2]) continue;
            quadratic[m][terms[m]] = square[i][j];
            linear[m][terms[m]] = k;
            ++terms[m];
          }
        }
      }
    }
  }
};
constexpr Monomials kMonomials;

/// A form in x, y, z, 1. Copies of numbers in memory, because the compiler keeps only those in registers.
struct LinearForm {
  DoubleV c[4];

  explicit LinearForm(const DoubleV* from) {
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) c[i] = from[i];
  }
};

struct QuadraticForm {
  DoubleV c[10] = {};

  template <int sign>
  void addProduct(const LinearForm& a, const LinearForm& b) {
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
#pragma GCC unroll 4
      for (int j = 0; j < 4; ++j) {
        DoubleV& sum = c[kMonomials.square[i][j]];
        sum = sign > 0 ? sum + a.c[i] * b.c[j] : sum - a.c[i] * b.c[j];
      }
    }
  }
};

/// Writes q0 l0 + q1 l1 + q2 l2, quadratic times linear forms, as one row of the equations.
__attribute__((noinline)) inline void writeCubic(const QuadraticForm& q0, const QuadraticForm& q1,
                                                 const QuadraticForm& q2, const LinearForm (&l)[3],
                                                 DoubleV (*columns)[10], int row) {
  const QuadraticForm* const q[3] = {&q0, &q1, &q2};
  DoubleV linear[3][4];
#pragma GCC unroll 3
  for (int k = 0; k < 3; ++k) {
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) linear[k][i] = l[k].c[i];
  }
#pragma GCC unroll 20
  for (int m = 0; m < 20; ++m) {
    DoubleV sum{};
#pragma GCC unroll 3
    for (int k = 0; k < 3; ++k) {
      DoubleV part = q[k]->c[kMonomials.quadratic[m][0]] * linear[k][kMonomials.linear[m][0]];
#pragma GCC unroll 2
      for (int t = 1; t < kMonomials.terms[m]; ++t)
        part += q[k]->c[kMonomials.quadratic[m][t]] * linear[k][kMonomials.linear[m][t]];
      sum = k == 0 ? part : sum + part;
    }
    columns[m][row] = sum;
  }
}

/// E E^T - trace(E E^T) / 2 I, the upper triangle in rows.
inline void writeTraceForms(const DoubleV (&e)[9][4], QuadraticForm (&forms)[6]) {
  constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
  for (int f = 0; f < 6; ++f) {
    QuadraticForm sum;
    for (int k = 0; k < 3; ++k) {
      sum.addProduct<1>(LinearForm(e[3 * kRow[f] + k]), LinearForm(e[3 * kColumn[f] + k]));
    }
#pragma GCC unroll 10
    for (int m = 0; m < 10; ++m) forms[f].c[m] = sum.c[m];
  }
  for (int m = 0; m < 10; ++m) {
    const DoubleV half = 0.5 * (forms[0].c[m] + forms[3].c[m] + forms[5].c[m]);
    forms[0].c[m] -= half;
    forms[3].c[m] -= half;
    forms[5].c[m] -= half;
  }
}

/// (E E^T - trace / 2 I) E = 0 and det E = 0 with E = x N0 + y N1 + z N2 + N3: one row each, one column per
/// monomial.
inline void writeConstraints(const DoubleV (&basis)[4][9], DoubleV (&columns)[20][10]) {
  DoubleV e[9][4];
  for (int i = 0; i < 9; ++i) {
    for (int b = 0; b < 4; ++b) e[i][b] = basis[b][i];
  }
  QuadraticForm forms[6], minors[3];
  writeTraceForms(e, forms);
  constexpr int kForm[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
  for (int j = 0; j < 3; ++j) {
    const LinearForm column[3] = {LinearForm(e[j]), LinearForm(e[3 + j]), LinearForm(e[6 + j])};
    for (int i = 0; i < 3; ++i) {
      const int(&f)[3] = kForm[i];
      writeCubic(forms[f[0]], forms[f[1]], forms[f[2]], column, columns, 3 * i + j);
    }
    const int next = (j + 1) % 3, last = (j + 2) % 3;
    minors[j].addProduct<1>(LinearForm(e[3 + next]), LinearForm(e[6 + last]));
    minors[j].addProduct<-1>(LinearForm(e[3 + last]), LinearForm(e[6 + next]));
  }
  const LinearForm first[3] = {LinearForm(e[0]), LinearForm(e[1]), LinearForm(e[2])};
  writeCubic(minors[0], minors[1], minors[2], first, columns, 9);
}

// ---- The polynomial in z ----

/// Two successive reflections. Rows before 4 are not used after their reflection.
template <int k>
struct ReflectionPair {
  const DoubleV (*vector)[10];
  DoubleV factor[2];

  /// Makes them of columns k and k + 1.
  ReflectionPair(DoubleV (&columns)[20][10], DoubleV (&diagonal)[10]) : vector(columns + k) {
    factor[0] = makeReflection<k, 10>(columns[k], diagonal[k]);
    reflect<k, 10>(vector[0], factor[0], columns[k + 1]);
    factor[1] = makeReflection<k + 1, 10>(columns[k + 1], diagonal[k + 1]);
  }

  void apply(DoubleV (&first)[10], DoubleV (&second)[10]) const {
    reflectTwo<k, 10, (k < 4 ? k + 1 : k)>(vector[0], factor[0], first, second);
    reflectTwo<k + 1, 10, (k < 4 ? k + 2 : k + 1)>(vector[1], factor[1], first, second);
  }
};

/// Triangularises the left half from column k + 2 on. The next two reflections are computed before the other
/// columns are reflected, because their roots and quotients take long.
template <int k>
inline void triangulateConstraints(DoubleV (&columns)[20][10], DoubleV (&diagonal)[10],
                                   const ReflectionPair<k>& pair) {
  pair.apply(columns[k + 2], columns[k + 3]);
  if constexpr (k < 6) {
    const ReflectionPair<k + 2> next(columns, diagonal);
    for (int c = k + 4; c < 20; c += 2) pair.apply(columns[c], columns[c + 1]);
    triangulateConstraints<k + 2>(columns, diagonal, next);
  } else {
    const DoubleV factor = makeReflection<8, 10>(columns[8], diagonal[8]);
    reflect<8, 10>(columns[8], factor, columns[9]);
    diagonal[9] = columns[9][9];
    for (int c = 10; c < 20; c += 2) {
      pair.apply(columns[c], columns[c + 1]);
      reflectTwo<8, 10>(columns[8], factor, columns[c], columns[c + 1]);
    }
  }
}

/// Solves the triangular system for rows 4 to 9: monomial 4 + r = -sum of reduced[r][c] times monomial 10 +
/// c.
inline void reduce(DoubleV (&columns)[20][10], DoubleV (&reduced)[6][10]) {
  DoubleV diagonal[10], inverse[10];
  triangulateConstraints<0>(columns, diagonal, ReflectionPair<0>(columns, diagonal));
  for (int r = 4; r < 10; ++r) inverse[r] = 1.0 / diagonal[r];
  for (int c = 0; c < 10; ++c) {
    DoubleV x[10];
#pragma GCC unroll 6
    for (int r = 9; r >= 4; --r) {
      DoubleV sum = columns[10 + c][r];
#pragma GCC unroll 6
      for (int k = 9; k > r; --k) sum -= columns[k][r] * x[k];
      x[r] = sum * inverse[r];
      reduced[r - 4][c] = x[r];
    }
  }
}

/// The rows of B(z) are differences of two rows, the second one times z, in which the monomials of the left
/// half cancel.
inline void writeRow(const DoubleV (&a)[10], const DoubleV (&b)[10], DoubleV (&row)[13]) {
  for (int half = 0; half < 2; ++half) {  // the multiples of x and of y
    const DoubleV *const p = a + 3 * half, *const q = b + 3 * half;
    DoubleV* const out = row + 4 * half;
    out[0] = p[2];
    out[1] = p[1] - q[2];
    out[2] = p[0] - q[1];
    out[3] = -q[0];
  }
  row[8] = a[9];
  row[9] = a[8] - b[9];
  row[10] = a[7] - b[8];
  row[11] = a[6] - b[7];
  row[12] = -b[6];
}

/// sum += (r0 s1 - s0 r1) t for the entries of three rows of B(z).
inline void addMinor(const DoubleV (&r)[13], const DoubleV (&s)[13], const DoubleV (&t)[13],
                     DoubleV (&sum)[11]) {
  DoubleV minor[7] = {}, p[11];
  for (int i = 0; i < 11; ++i) p[i] = sum[i];
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
#pragma GCC unroll 4
    for (int j = 0; j < 4; ++j) minor[i + j] += r[i] * s[4 + j] - s[i] * r[4 + j];
  }
#pragma GCC unroll 7
  for (int i = 0; i < 7; ++i) {
#pragma GCC unroll 5
    for (int j = 0; j < 5; ++j) p[i + j] += minor[i] * t[8 + j];
  }
  for (int i = 0; i < 11; ++i) sum[i] = p[i];
}

/// Sums and differences of the coefficients k and 10 - k: numbers 0 to 4 and 6 to 10; number 5 is the middle
/// one.
inline void fold(const DoubleV (&p)[11], int lane, FivePointState& state) {
  for (int k = 0; k < 5; ++k) {
    store(state.folded[k] + lane, p[k] + p[10 - k]);
    store(state.folded[10 - k] + lane, p[k] - p[10 - k]);
  }
  store(state.folded[5] + lane, p[5]);
}

/// Everything up to the polynomial for the samples of one vector.
inline void writePolynomials(const FivePointRays& rays, int lane, FivePointState& state) {
  DoubleV basis[4][9], columns[20][10], reduced[6][10], rows[3][13], p[11] = {};
  writeBasis(rays, lane, basis);
  writeConstraints(basis, columns);
  reduce(columns, reduced);
  for (int r = 0; r < 3; ++r) writeRow(reduced[2 * r], reduced[2 * r + 1], rows[r]);
  for (int r = 0; r < 3; ++r) addMinor(rows[(r + 1) % 3], rows[(r + 2) % 3], rows[r], p);
  for (int b = 0; b < 4; ++b) {
    for (int i = 0; i < 9; ++i) store(state.basis[b][i] + lane, basis[b][i]);
  }
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 13; ++k) store(state.cubic[r][k] + lane, rows[r][k]);
  }
  for (int k = 0; k < 11; ++k) store(state.polynomial[k] + lane, p[k]);
  fold(p, lane, state);
}

// ---- Brackets of the roots ----

/// The real line as z = tan(angle), so that infinity is a place like any other: the sign of the homogeneous
/// polynomial sum c_k sin^k cos^(10-k) at equidistant angles tells its roots. Where |z| > 1 the unknown is
/// 1 / z. Computed with additions, multiplications and divisions only, so that it is the same everywhere.
struct AngleTable {
  static constexpr int kAngles = 128, kBase = kAngles / 4;
  static constexpr double kStep = 0.02454369260617026;  // pi / 128
  /// Products sin^k cos^(10-k) at the angles between 0 and pi / 4, folded like the coefficients and halved.
  alignas(64) double products[kBase / 8][11][8] = {};
  double sine[kAngles] = {}, cosine[kAngles] = {};
  double unknown[2][kAngles] = {};  ///< tangent and cotangent

  constexpr AngleTable() {
    // sin and cos of pi / 256
    constexpr double kSine = 0x1.921d1fcdec784p-7, kCosine = 0x1.fff62169b92dbp-1;
    const double step_sine = 2 * kSine * kCosine, step_cosine = 1 - 2 * kSine * kSine;
    double s = kSine, c = kCosine;
    for (int i = 0; i < kBase; ++i) {
      setAngle(64 + i, s, c);
      setAngle(63 - i, -s, c);
      setAngle(127 - i, c, s);
      setAngle(i, -c, s);
      setProducts(i, s, c);
      const double next = s * step_cosine + c * step_sine;
      c = c * step_cosine - s * step_sine;
      s = next;
    }
  }

  constexpr void setAngle(int j, double s, double c) {
    sine[j] = s;
    cosine[j] = c;
    unknown[0][j] = s / c;
    unknown[1][j] = c / s;
  }

  constexpr void setProducts(int i, double s, double c) {
    double product[11] = {};
    for (int k = 0; k <= 10; ++k) {
      product[k] = 1;
      for (int n = 0; n < 10; ++n) product[k] *= n < k ? s : c;
    }
    for (int k = 0; k < 5; ++k) {
      products[i / 8][k][i % 8] = 0.5 * (product[k] + product[10 - k]);
      products[i / 8][10 - k][i % 8] = 0.5 * (product[k] - product[10 - k]);
    }
    products[i / 8][5][i % 8] = product[5];
  }

  /// Whether the unknown at angle j is the cotangent.
  static constexpr bool isInverse(int j) { return j < 32 || j >= 96; }
};
constexpr AngleTable kAngleTable;

/// Values of one polynomial at all angles; there is one more at each end, because angles are cyclic.
struct AngleValues {
  static constexpr int kBegin = 8;
  alignas(64) double value[kBegin + AngleTable::kAngles + 8];

  const double* at(int j) const { return value + kBegin + j; }

  /// The four angles +-a and +-(pi / 2 - a) share the even and the odd products of sine and cosine.
  void compute(const FivePointState& state, int sample) {
    double* const p = value + kBegin;
    const double* const c = state.folded[0] + sample;
    constexpr int n = kFivePointBatch;
    for (int i = 0; i < AngleTable::kBase; i += kDoubleWidth) {
      const double* const t = kAngleTable.products[i / 8][0] + i % 8;
      const DoubleV even = c[0] * load(t) + c[2 * n] * load(t + 16) + c[4 * n] * load(t + 32);
      const DoubleV even_difference =
          c[10 * n] * load(t + 80) + c[8 * n] * load(t + 64) + c[6 * n] * load(t + 48);
      const DoubleV odd = c[n] * load(t + 8) + c[3 * n] * load(t + 24) + c[5 * n] * load(t + 40);
      const DoubleV odd_difference = c[9 * n] * load(t + 72) + c[7 * n] * load(t + 56);
      const DoubleV e = even + even_difference, o = odd + odd_difference;
      const DoubleV f = even - even_difference, q = odd - odd_difference;
      store(p + 64 + i, e + o);
      store(p + 64 - kDoubleWidth - i, reversed(e - o));
      store(p + 128 - kDoubleWidth - i, reversed(f + q));
      store(p + i, f - q);
    }
    p[-1] = p[127];
    p[128] = p[0];
  }
};

/// A set of angles.
struct AngleSet {
  std::uint64_t word[2] = {};

  /// Moves every element to the next angle or to the one before.
  AngleSet next() const { return {{word[0] << 1 | word[1] >> 63, word[1] << 1 | word[0] >> 63}}; }
  AngleSet previous() const { return {{word[0] >> 1 | word[1] << 63, word[1] >> 1 | word[0] << 63}}; }
};

/// Angles j with a sign change between j and j + 1, and those in whose neighbourhood the magnitude has a
/// local minimum without a sign change.
inline void findChanges(const AngleValues& values, AngleSet& changes, AngleSet& minima) {
  AngleSet negative, rising;
  for (int w = 0; w < 2; ++w) {
    std::uint64_t is_negative = 0, is_rising = 0;
#pragma GCC unroll 32
    for (int j = 0; j < 64; j += kDoubleWidth) {
      const DoubleV p = load(values.at(64 * w + j)), next = load(values.at(64 * w + j + 1));
      is_negative |= lessBits(p, DoubleV{}) << j;
      is_rising |= lessBits(absolute(p), absolute(next)) << j;
    }
    negative.word[w] = is_negative;
    rising.word[w] = is_rising;
  }
  const AngleSet other = negative.previous(), falling = rising.next();
  for (int w = 0; w < 2; ++w) changes.word[w] = negative.word[w] ^ other.word[w];
  const AngleSet before = changes.next();
  for (int w = 0; w < 2; ++w)
    minima.word[w] = rising.word[w] & ~falling.word[w] & ~changes.word[w] & ~before.word[w];
}

constexpr int kMaxRoots = kFivePointBatch * kFivePointSolutions;

/// Places in whose neighbourhood a polynomial has roots, at most kFivePointSolutions per sample.
struct Places {
  alignas(64) std::int64_t sample[kMaxRoots];
  std::int64_t inverse[kMaxRoots];  ///< all ones where the unknown is 1 / z
  int size = 0;
};

/// Intervals with a sign change of the polynomial.
struct Brackets : Places {
  alignas(64) double first[kMaxRoots], last[kMaxRoots], first_value[kMaxRoots], last_value[kMaxRoots];
  int count[kFivePointBatch] = {};

  void add(std::int64_t of_sample, std::int64_t is_inverse, double from, double from_value, double to,
           double to_value) {
    if (count[of_sample] == kFivePointSolutions) return;
    ++count[of_sample];
    sample[size] = of_sample;
    inverse[size] = is_inverse;
    first[size] = from;
    first_value[size] = from_value;
    last[size] = to;
    last_value[size] = to_value;
    ++size;
  }

  /// Fills up the last vector.
  void pad() {
    for (int i = size; i % kDoubleWidth != 0; ++i) {
      sample[i] = sample[0];
      inverse[i] = inverse[0];
      first[i] = first[0];
      first_value[i] = first_value[0];
      last[i] = last[0];
      last_value[i] = last_value[0];
    }
  }
};

/// Minima of the magnitude, with the angles before and behind.
struct Minima : Places {
  alignas(64) double before[kMaxRoots], value[kMaxRoots], behind[kMaxRoots];
  std::int64_t angle[kMaxRoots];
};

/// Calls action(j) for the first kFivePointSolutions elements, which are as many as a polynomial of degree 10
/// can have.
template <class Action>
inline void forEach(AngleSet set, Action action) {
  int count = 0;
  for (int w = 0; w < 2; ++w) {
    for (std::uint64_t bits = set.word[w]; bits != 0 && count < kFivePointSolutions; bits &= bits - 1) {
      action(64 * w + __builtin_ctzll(bits));
      ++count;
    }
  }
}

inline void findPlaces(const FivePointState& state, int sample, Brackets& brackets, Minima& minima) {
  AngleValues values;
  AngleSet changed, smallest;
  values.compute(state, sample);
  findChanges(values, changed, smallest);
  forEach(changed, [&](int j) {
    const bool inverse = AngleTable::isInverse(j);
    const double* const unknown = kAngleTable.unknown[inverse ? 1 : 0];
    brackets.add(sample, inverse ? -1 : 0, unknown[j], *values.at(j), unknown[(j + 1) % 128],
                 *values.at(j + 1));
  });
  forEach(smallest, [&](int j) {
    const int i = minima.size++;
    minima.sample[i] = sample;
    minima.inverse[i] = AngleTable::isInverse(j) ? -1 : 0;
    minima.before[i] = *values.at(j - 1);
    minima.value[i] = *values.at(j);
    minima.behind[i] = *values.at(j + 1);
    minima.angle[i] = j;
  });
}

// ---- Roots ----

/// a where the mask is all ones, b where it is zero.
inline DoubleV select(LongV mask, DoubleV a, DoubleV b) {
  return (DoubleV)(((LongV)a & mask) | ((LongV)b & ~mask));
}

/// Takes the numbers of the roots' samples.
struct Picker {
#if defined(__AVX512F__)
  __m512i sample;
  explicit Picker(LongV lanes) : sample((__m512i)lanes) {}
  DoubleV operator()(const double* row) const {
    return (DoubleV)_mm512_maskz_permutexvar_pd(static_cast<__mmask8>(-1), sample, (__m512d)load(row));
  }
#elif defined(__AVX2__)
  __m256i halves;  // numbers of the halves of a double within four of them
  __m256d upper;
  explicit Picker(LongV lanes)
      : halves((__m256i)(((lanes & 3) * 0x200000002) | 0x100000000)), upper((__m256d)(lanes > 3)) {}
  DoubleV operator()(const double* row) const {
    const __m256 low = _mm256_permutevar8x32_ps((__m256)load(row), halves);
    const __m256 high = _mm256_permutevar8x32_ps((__m256)load(row + 4), halves);
    return (DoubleV)_mm256_blendv_pd((__m256d)low, (__m256d)high, upper);
  }
#else
  std::int64_t sample[kDoubleWidth];
  explicit Picker(LongV lanes) { store(sample, lanes); }
  DoubleV operator()(const double* row) const { return DoubleV{row[sample[0]], row[sample[1]]}; }
#endif
};

/// The polynomial in the unknown, ascending: in z, or reversed in 1 / z.
struct RootPolynomial {
  DoubleV c[11];

  void pickCoefficients(const FivePointState& state, const Picker& pick, LongV inverse) {
    for (int k = 0; k < 11; ++k) c[k] = pick(state.polynomial[k]);
    for (int k = 0; k < 5; ++k) {
      const DoubleV low = c[k], high = c[10 - k];
      c[k] = select(inverse, high, low);
      c[10 - k] = select(inverse, low, high);
    }
  }

  DoubleV value(DoubleV u) const {
    DoubleV result = c[10];
#pragma GCC unroll 10
    for (int k = 9; k >= 0; --k) result = result * u + c[k];
    return result;
  }

  DoubleV value(DoubleV u, DoubleV& slope) const {
    DoubleV result = c[10] * u + c[9];
    slope = c[10];
#pragma GCC unroll 9
    for (int k = 8; k >= 0; --k) {
      slope = slope * u + result;
      result = result * u + c[k];
    }
    return result;
  }
};

/// Tries the vertices of the parabolas through three values at a minimum. Where the polynomial has the other
/// sign there, two close roots lie on both sides.
inline void splitMinima(const FivePointState& state, Minima& minima, Brackets& brackets) {
  for (int begin = 0; begin < minima.size; begin += kDoubleWidth) {
    alignas(64) double tried[kDoubleWidth], tried_value[kDoubleWidth];
    double sine[kDoubleWidth], cosine[kDoubleWidth];
    const int end = minima.size - begin < kDoubleWidth ? minima.size - begin : kDoubleWidth;
    for (int k = end; k < kDoubleWidth; ++k) {
      minima.sample[begin + k] = minima.sample[begin];
      minima.inverse[begin + k] = minima.inverse[begin];
      minima.angle[begin + k] = minima.angle[begin];
      minima.before[begin + k] = minima.value[begin + k] = minima.behind[begin + k] = 0;
    }
    for (int k = 0; k < kDoubleWidth; ++k) {
      sine[k] = kAngleTable.sine[minima.angle[begin + k]];
      cosine[k] = kAngleTable.cosine[minima.angle[begin + k]];
    }
    const LongV inverse = load(minima.inverse + begin);
    const DoubleV before = load(minima.before + begin), behind = load(minima.behind + begin);
    const DoubleV at = load(minima.value + begin), s = load(sine), c = load(cosine);
    const DoubleV shift = (0.5 * AngleTable::kStep) * (before - behind) / (before - 2.0 * at + behind);
    const DoubleV s_there = s + c * shift, c_there = c - s * shift;
    const DoubleV u = select(inverse, c_there, s_there) / select(inverse, s_there, c_there);
    RootPolynomial p;
    p.pickCoefficients(state, Picker(load(minima.sample + begin)), inverse);
    store(tried, u);
    store(tried_value, p.value(u));
    for (int k = 0; k < end; ++k) {
      const int i = begin + k, j = static_cast<int>(minima.angle[i]);
      if (!(minima.value[i] < 0 ? tried_value[k] > 0 : tried_value[k] < 0)) continue;
      const double* const unknown = kAngleTable.unknown[minima.inverse[i] != 0 ? 1 : 0];
      brackets.add(minima.sample[i], minima.inverse[i], unknown[(j + 127) % 128], minima.before[i], tried[k],
                   tried_value[k]);
      brackets.add(minima.sample[i], minima.inverse[i], tried[k], tried_value[k], unknown[(j + 1) % 128],
                   minima.behind[i]);
    }
  }
}

constexpr int kRootVectors = kMaxRoots / kDoubleWidth;

/// Some roots of polynomials, each in a bracket.
struct RootSearch {
  static constexpr double kTolerance = 1e-9;  ///< the next step would change the last digits only

  RootPolynomial polynomial;
  DoubleV root, moved;               ///< the last estimate and the step that led to it
  DoubleV first, last, first_value;  ///< bracket

  /// Starts with the secant.
  void start(const FivePointState& state, const Brackets& brackets, int begin) {
    polynomial.pickCoefficients(state, Picker(load(brackets.sample + begin)), load(brackets.inverse + begin));
    first = load(brackets.first + begin);
    last = load(brackets.last + begin);
    first_value = load(brackets.first_value + begin);
    moved = first_value / (first_value - load(brackets.last_value + begin)) * (last - first);
    root = first + moved;
  }

  /// A step of Newton's method, or of bisection where that would leave the bracket.
  void step() {
    DoubleV slope;
    const DoubleV value = polynomial.value(root, slope);
    const LongV differs = (value < 0.0) ^ (first_value < 0.0);
    first = select(differs, first, root);
    last = select(differs, root, last);
    const DoubleV newton = root - value / slope, middle = 0.5 * (first + last);
    const LongV inside = (newton - first) * (newton - last) <= 0.0;
    const DoubleV next = select(inside, newton, middle);
    const LongV active = absolute(moved) > kTolerance;
    moved = select(active, next - root, moved);
    root = select(active, next, root);
  }

  bool isDone() const { return lessBits(kTolerance - DoubleV{}, absolute(moved)) == 0; }
};

/// Vectors of roots advance in turn, so that they do not wait for each other's results.
inline void solveBrackets(const FivePointState& state, const Brackets& brackets, int vectors,
                          RootSearch* searches) {
  constexpr int kMaxSteps = 12;
  for (int v = 0; v < vectors; ++v) searches[v].start(state, brackets, v * kDoubleWidth);
  for (int step = 0; step < kMaxSteps; ++step) {
    for (int v = 0; v < vectors; ++v) {
      if (!searches[v].isDone()) searches[v].step();
    }
  }
}

/// E for roots of the polynomial: (x : y : 1) is orthogonal to the rows of B(z), of which the pair with the
/// longest cross product counts.
struct RootMatrix {
  DoubleV entry[9];
  std::uint64_t exists;  ///< one bit per lane: whether the matrix is neither 0 nor infinite nor NaN

  RootMatrix(const FivePointState& state, const Picker& pick, LongV inverse, DoubleV u) {
    // z = s / c
    const DoubleV one = 1.0 - DoubleV{}, s = select(inverse, one, u), c = select(inverse, u, one);
    DoubleV rows[3][3], direction[3];
    writeRows(state, pick, s, c, rows);
    longestCross(rows, direction);
    // The rows are homogeneous in s and c, so that the direction is (c x : c y : 1).
    const DoubleV factor[4] = {direction[0], direction[1], direction[2] * s, direction[2] * c};
    DoubleV square{};
    for (int i = 0; i < 9; ++i) {
      DoubleV sum = factor[0] * pick(state.basis[0][i]);
      for (int b = 1; b < 4; ++b) sum += factor[b] * pick(state.basis[b][i]);
      entry[i] = sum;
      square += sum * sum;
    }
    exists = lessBits(1e-290 - DoubleV{}, square) & lessBits(square, 1e290 - DoubleV{});
    const DoubleV scale = 1.0 / squareRoot(square);
    for (DoubleV& value : entry) value *= scale;
  }

  static void writeRows(const FivePointState& state, const Picker& pick, DoubleV s, DoubleV c,
                        DoubleV (&rows)[3][3]) {
    const DoubleV s2 = s * s, c2 = c * c;
    const DoubleV cubic[4] = {c2 * c, c2 * s, s2 * c, s2 * s};
    const DoubleV quartic[5] = {c2 * c2, cubic[0] * s, c2 * s2, cubic[3] * c, s2 * s2};
    for (int r = 0; r < 3; ++r) {
      for (int column = 0; column < 3; ++column) {
        const double(*const p)[kFivePointBatch] = state.cubic[r] + 4 * column;
        const DoubleV* const powers = column < 2 ? cubic : quartic;
        DoubleV sum = pick(p[0]) * powers[0];
        for (int k = 1; k < (column < 2 ? 4 : 5); ++k) sum += pick(p[k]) * powers[k];
        rows[r][column] = sum;
      }
    }
  }

  static void longestCross(const DoubleV (&rows)[3][3], DoubleV (&longest)[3]) {
    DoubleV largest = {};
    for (DoubleV& value : longest) value = DoubleV{};
    for (int r = 0; r < 3; ++r) {
      const DoubleV(&a)[3] = rows[r], (&b)[3] = rows[(r + 1) % 3];
      const DoubleV cross[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                                a[0] * b[1] - a[1] * b[0]};
      const DoubleV square = cross[0] * cross[0] + cross[1] * cross[1] + cross[2] * cross[2];
      const LongV longer = square > largest;
      largest = longer ? square : largest;
      for (int k = 0; k < 3; ++k) longest[k] = longer ? cross[k] : longest[k];
    }
  }
};

inline void fivePointKernel(const FivePointRays& rays, int count, double (*solutions)[kFivePointSolutions][9],
                            int* counts) {
  FivePointState state;
  for (int lane = 0; lane < count; lane += kDoubleWidth) writePolynomials(rays, lane, state);
  Brackets brackets;
  Minima minima;
  for (int sample = 0; sample < count; ++sample) findPlaces(state, sample, brackets, minima);
  splitMinima(state, minima, brackets);
  brackets.pad();
  const int vectors = (brackets.size + kDoubleWidth - 1) / kDoubleWidth;
  RootSearch searches[kRootVectors];
  solveBrackets(state, brackets, vectors, searches);
  for (int sample = 0; sample < count; ++sample) counts[sample] = 0;
  for (int v = 0; v < vectors; ++v) {
    const int begin = v * kDoubleWidth;
    const RootMatrix e(state, Picker(load(brackets.sample + begin)), load(brackets.inverse + begin),
                       searches[v].root);
    for (int k = 0; k < kDoubleWidth && begin + k < brackets.size; ++k) {
      if ((e.exists >> k & 1) == 0) continue;
      const std::int64_t sample = brackets.sample[begin + k];
      double* const out = solutions[sample][counts[sample]++];
      for (int i = 0; i < 9; ++i) out[i] = e.entry[i][k];
    }
  }
}

}  // namespace
}  // namespace corrsel::core
