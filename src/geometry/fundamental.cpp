#include "geometry/fundamental.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/homography.h"
#include "geometry/residual.h"

namespace corrsel::core {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;

Vector9 epipolarRow(const NormalizedMatches& m, std::uint32_t i) {
  const double x = m.left_x[i], y = m.left_y[i], u = m.right_x[i], v = m.right_y[i];
  Vector9 row;
  row << u * x, u * y, u, v * x, v * y, v, x, y, 1;
  return row;
}

cv::Matx33d toMatrix(const Vector9& v) {
  return cv::Matx33d(v(0), v(1), v(2), v(3), v(4), v(5), v(6), v(7), v(8));
}

using SevenRows = std::array<std::array<double, 9>, 7>;

struct Pivot {
  double magnitude;
  std::size_t row, column;
};

/// Finds the element of the largest magnitude from row `step` on.
/// @pre these rows are 0 left of column `step`
Pivot pivotOf(const SevenRows& a, std::size_t step) {
  // Loops over all columns, without branches, can use vectors.
  std::array<double, 9> largest{};
  for (std::size_t r = step; r < 7; ++r) {
    for (std::size_t c = 0; c < 9; ++c) {
      const double magnitude = std::abs(a[r][c]);
      largest[c] = largest[c] < magnitude ? magnitude : largest[c];
    }
  }
  const std::size_t column = std::size_t(std::max_element(largest.begin(), largest.end()) - largest.begin());
  std::size_t row = step;
  while (row < 6 && std::abs(a[row][column]) < largest[column]) ++row;
  return {largest[column], row, column};
}

/// Computes two vectors of the null space of a 7x9 matrix by Gauss-Jordan elimination with full pivoting.
/// @return the rank; below 6, there are no vectors
int nullSpace(SevenRows& a, Vector9& first, Vector9& second) {
  std::array<int, 9> column = {0, 1, 2, 3, 4, 5, 6, 7, 8};
  std::size_t rank = 0;
  for (; rank < 7; ++rank) {
    const std::size_t step = rank;
    const Pivot pivot = pivotOf(a, step);
    if (pivot.magnitude < 1e-9) break;
    std::swap(a[step], a[pivot.row]);
    if (pivot.column != step) {
      for (auto& row : a) std::swap(row[step], row[pivot.column]);
      std::swap(column[step], column[pivot.column]);
    }
    const double inverse = 1.0 / a[step][step];
    for (double& element : a[step]) element *= inverse;
    for (std::size_t r = 0; r < 7; ++r) {
      if (r == step) continue;
      const double factor = a[r][step];
      for (std::size_t c = 0; c < 9; ++c) a[r][c] -= factor * a[step][c];
    }
  }
  if (rank < 6) return static_cast<int>(rank);
  first.setZero();
  second.setZero();
  for (std::size_t r = 0; r < rank; ++r) {
    first(column[r]) = -a[r][7];
    second(column[r]) = -a[r][8];
  }
  first(column[7]) = 1;
  second(column[8]) = 1;
  first.normalize();
  second.normalize();
  return static_cast<int>(rank);
}

/// Real roots of a x^3 + b x^2 + c x + d.
int realRoots(double a, double b, double c, double d, double roots[3]) {
  const double largest = std::max({std::abs(a), std::abs(b), std::abs(c), std::abs(d)});
  if (largest == 0) return 0;
  if (std::abs(a) < 1e-12 * largest) {
    if (std::abs(b) < 1e-12 * largest) {
      if (std::abs(c) < 1e-12 * largest) return 0;
      roots[0] = -d / c;
      return 1;
    }
    const double discriminant = c * c - 4 * b * d;
    if (discriminant < 0) return 0;
    const double q = -0.5 * (c + (c < 0 ? -1 : 1) * std::sqrt(discriminant));
    int count = 0;
    roots[count++] = q / b;
    if (q != 0) roots[count++] = d / q;
    return count;
  }
  b /= a;
  c /= a;
  d /= a;
  const double q = (b * b - 3 * c) / 9, r = (2 * b * b * b - 9 * b * c + 27 * d) / 54;
  const double shift = b / 3;
  int count = 0;
  if (r * r < q * q * q) {
    const double theta = std::acos(r / std::sqrt(q * q * q)), factor = -2 * std::sqrt(q);
    constexpr double kThird = 2.0943951023931957;  // 2 pi / 3
    roots[count++] = factor * std::cos(theta / 3) - shift;
    roots[count++] = factor * std::cos(theta / 3 + kThird) - shift;
    roots[count++] = factor * std::cos(theta / 3 - kThird) - shift;
  } else {
    const double s = -(r < 0 ? -1.0 : 1.0) * std::cbrt(std::abs(r) + std::sqrt(r * r - q * q * q));
    roots[count++] = s + (s != 0 ? q / s : 0.0) - shift;
  }
  for (int i = 0; i < count; ++i) {
    // One Newton step removes the error that cancellation leaves in the closed form.
    const double x = roots[i];
    const double slope = (3 * x + 2 * b) * x + c;
    if (slope != 0) roots[i] = x - (((x + b) * x + c) * x + d) / slope;
  }
  return count;
}

/// Oriented epipolar constraint: with e' the right epipole, (e' x x') and F x are parallel with the same sign
/// for all points, or with the opposite sign for all.
bool isOriented(const cv::Matx33d& f, const NormalizedMatches& m, const std::uint32_t* sample) {
  const cv::Vec3d epipole = leftNullVector(f);
  if (epipole == cv::Vec3d(0, 0, 0)) return false;
  int positive = 0;
  for (int k = 0; k < 7; ++k) {
    const std::uint32_t i = sample[k];
    const cv::Vec3d line = f * cv::Vec3d(m.left_x[i], m.left_y[i], 1);
    positive += epipole.cross(cv::Vec3d(m.right_x[i], m.right_y[i], 1)).dot(line) > 0 ? 1 : 0;
  }
  return positive == 0 || positive == 7;
}

double determinant(const cv::Matx33d& m) {
  return m(0, 0) * (m(1, 1) * m(2, 2) - m(1, 2) * m(2, 1)) -
         m(0, 1) * (m(1, 0) * m(2, 2) - m(1, 2) * m(2, 0)) +
         m(0, 2) * (m(1, 0) * m(2, 1) - m(1, 1) * m(2, 0));
}

/// The nearest matrix of rank 2: F - F v v^T, v being the right singular vector of the smallest singular
/// value.
cv::Matx33d enforceRankTwo(const cv::Matx33d& f) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> matrix(f.val);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(matrix.transpose() * matrix);
  const Eigen::Vector3d v = solver.eigenvectors().col(0);
  cv::Matx33d result;
  Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(result.val) =
      matrix - (matrix * v) * v.transpose();
  return result;
}

/// Squared norm of the gradient of x'^T F x with respect to the four coordinates.
double gradientNorm(const cv::Matx33d& f, double x, double y, double u, double v) {
  const double a = f(0, 0) * x + f(0, 1) * y + f(0, 2), b = f(1, 0) * x + f(1, 1) * y + f(1, 2);
  const double c = f(0, 0) * u + f(1, 0) * v + f(2, 0), d = f(0, 1) * u + f(1, 1) * v + f(2, 1);
  return a * a + b * b + c * c + d * d;
}

}  // namespace

cv::Vec3d leftNullVector(const cv::Matx33d& f) {
  cv::Vec3d result(0, 0, 0);
  double largest = 0;
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3;
    const cv::Vec3d product =
        cv::Vec3d(f(0, a), f(1, a), f(2, a)).cross(cv::Vec3d(f(0, b), f(1, b), f(2, b)));
    const double norm = product.dot(product);
    if (norm > largest) {
      largest = norm;
      result = product;
    }
  }
  return result;
}

double sampsonError(const cv::Matx33d& f, double x, double y, double u, double v) {
  const double residual = u * (f(0, 0) * x + f(0, 1) * y + f(0, 2)) +
                          v * (f(1, 0) * x + f(1, 1) * y + f(1, 2)) + f(2, 0) * x + f(2, 1) * y + f(2, 2);
  const double gradient = gradientNorm(f, x, y, u, v);
  if (gradient == 0) return residual == 0 ? 0.0 : std::numeric_limits<double>::infinity();
  return residual * residual / gradient;
}

double epipolarLineDistance(const cv::Matx33d& f, double x, double y, double u, double v) {
  const double a = f(0, 0) * x + f(0, 1) * y + f(0, 2), b = f(1, 0) * x + f(1, 1) * y + f(1, 2);
  const double c = f(2, 0) * x + f(2, 1) * y + f(2, 2);
  return std::abs(a * u + b * v + c) / std::sqrt(a * a + b * b);
}

bool isValidFundamentalSample(const NormalizedMatches& m, const std::uint32_t* s) {
  for (int a = 0; a < 7; ++a) {
    for (int b = 0; b < a; ++b) {
      if (m.left_x[s[a]] == m.left_x[s[b]] && m.left_y[s[a]] == m.left_y[s[b]] &&
          m.right_x[s[a]] == m.right_x[s[b]] && m.right_y[s[a]] == m.right_y[s[b]]) {
        return false;
      }
    }
  }
  const auto onLine = [&m, s](const std::vector<float>& x, const std::vector<float>& y) {
    // Any two different points span the line.
    int b = 1;
    while (b < 7 && x[s[b]] == x[s[0]] && y[s[b]] == y[s[0]]) ++b;
    for (int c = b + 1; c < 7; ++c) {
      if (triangleArea(x, y, s[0], s[b], s[c], m.rounding) != 0) return false;
    }
    return true;
  };
  return !onLine(m.left_x, m.left_y) && !onLine(m.right_x, m.right_y);
}

int fundamentalFromSeven(const NormalizedMatches& m, const std::uint32_t* sample, cv::Matx33d f[3]) {
  SevenRows rows;
  for (std::size_t k = 0; k < 7; ++k) {
    const Vector9 row = epipolarRow(m, sample[k]);
    for (int c = 0; c < 9; ++c) rows[k][static_cast<std::size_t>(c)] = row(c);
  }
  Vector9 first, second;
  const int rank = nullSpace(rows, first, second);
  if (rank < 6) return 0;
  // det(lambda A + (1 - lambda) B) = det(B + lambda D), D = A - B, is a cubic: two determinants and its
  // values at 1 and -1 determine it.
  const cv::Matx33d b = toMatrix(second), d = toMatrix(first) - b;
  const double c0 = determinant(b), c3 = determinant(d);
  const double plus = determinant(b + d), minus = determinant(b - d);
  const double c2 = 0.5 * (plus + minus) - c0, c1 = 0.5 * (plus - minus) - c3;
  double roots[3] = {0.5};
  int count = 1;
  if (rank == 7) {
    count = realRoots(c3, c2, c1, c0, roots);
  } else if (std::max({std::abs(c0), std::abs(c1), std::abs(c2), std::abs(c3)}) > 1e-9) {
    return 0;
  }
  int kept = 0;
  for (int i = 0; i < count; ++i) {
    cv::Matx33d candidate = b + d * roots[i];
    const double norm = cv::norm(candidate);
    if (!(norm > 1e-12) || !std::isfinite(norm)) continue;
    candidate = candidate * (1.0 / norm);
    if (isOriented(candidate, m, sample)) f[kept++] = candidate;
  }
  return kept;
}

bool refineFundamental(const NormalizedMatches& matches, float squared_threshold, cv::Matx33d& f) {
  using Matrix9 = Eigen::Matrix<double, 9, 9>;
  constexpr auto kResidual = Residual::kSampson;
  double sums[kFundamentalSums];
  kernels().residuals.normal[static_cast<std::size_t>(kResidual)](residualModel(kResidual, f),
                                                                  matches.columns(), squared_threshold, sums);
  Matrix9 normal;
  const double* block = sums;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j, block += 6) {
      int k = 0;
      for (int a = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b, ++k) {
          normal(3 * i + a, 3 * j + b) = normal(3 * i + b, 3 * j + a) = block[k];
          normal(3 * j + a, 3 * i + b) = normal(3 * j + b, 3 * i + a) = block[k];
        }
      }
    }
  }
  // Steps stay on the surface |F| = 1, det F = 0 to first order: its normals are F itself and its cofactors.
  const cv::Matx33d cofactors = adjugateOf(f).t();
  Eigen::Matrix<double, 9, 2> normals;
  normals.col(0) = Eigen::Map<const Vector9>(f.val);
  normals.col(1) = Eigen::Map<const Vector9>(cofactors.val);
  if (!(normals.col(1).norm() > 1e-12)) return false;
  normals.col(1).normalize();
  const Matrix9 basis = Eigen::HouseholderQR<Eigen::Matrix<double, 9, 2>>(normals).householderQ();
  const Eigen::Matrix<double, 9, 7> tangent = basis.rightCols<7>();
  const Eigen::Matrix<double, 7, 7> reduced = tangent.transpose() * normal * tangent;
  const Eigen::LDLT<Eigen::Matrix<double, 7, 7>> solver(reduced);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-12 * reduced.trace()))
    return false;
  const Eigen::Matrix<double, 7, 1> right = tangent.transpose() * (normal * normals.col(0));
  const Vector9 refined = normals.col(0) - tangent * solver.solve(right);
  const cv::Matx33d candidate = enforceRankTwo(toMatrix(refined));
  const double norm = cv::norm(candidate);
  if (!std::isfinite(norm) || !(norm > 0)) return false;
  f = candidate * (1.0 / norm);
  return true;
}

}  // namespace corrsel::core
