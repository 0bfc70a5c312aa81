#pragma once

#include <cmath>
#include <opencv2/core.hpp>  // determinant()
#include <stdexcept>
#include <string>

#include "base/text.h"

namespace corrsel::core {

/// "[a b; c d]"
template <int Rows, int Columns>
std::string matrixText(const cv::Matx<double, Rows, Columns>& matrix) {
  std::string result;
  for (int row = 0; row < Rows; ++row) {
    for (int column = 0; column < Columns; ++column) {
      result += (row + column == 0 ? "" : column == 0 ? "; " : " ") + formatNumber(matrix(row, column));
    }
  }
  return "[" + result + "]";
}

/// Throws std::invalid_argument naming the matrix and its value where a number is not finite.
template <int Rows, int Columns>
void requireFinite(const char* name, const cv::Matx<double, Rows, Columns>& matrix) {
  for (const double value : matrix.val) {
    if (!std::isfinite(value)) {
      throw std::invalid_argument(std::string(name) + " = " + matrixText(matrix) + " is not finite");
    }
  }
}

/// Throws std::invalid_argument naming the matrix and its value where it differs from a rotation by more than
/// 1e-4.
inline void requireRotation(const char* name, const cv::Matx33d& r) {
  constexpr double kTolerance = 1e-4;
  requireFinite(name, r);
  const double fault = cv::norm(r * r.t() - cv::Matx33d::eye());
  if (fault <= kTolerance && cv::determinant(r) > 0) return;
  throw std::invalid_argument(
      std::string(name) + " = " + matrixText(r) +
      " is not a rotation: its rows must be orthogonal, of length 1, and its determinant 1");
}

/// Throws std::invalid_argument naming the vector and its value where its length differs from 1 by more than
/// 1e-6.
inline void requireDirection(const char* name, const cv::Vec3d& vector) {
  constexpr double kTolerance = 1e-6;
  requireFinite(name, vector);
  if (std::abs(cv::norm(vector) - 1) <= kTolerance) return;
  throw std::invalid_argument(std::string(name) + " = " + matrixText(vector.t()) + " must have length 1");
}

/// Throws std::invalid_argument naming the matrix and its value unless it is [fx s cx; 0 fy cy; 0 0 1] with
/// finite numbers and positive focal lengths.
inline void requireCameraMatrix(const char* name, const cv::Matx33d& k) {
  requireFinite(name, k);
  const bool form = k(1, 0) == 0 && k(2, 0) == 0 && k(2, 1) == 0 && k(2, 2) == 1;
  if (!form || !(k(0, 0) > 0) || !(k(1, 1) > 0)) {
    throw std::invalid_argument(std::string(name) + " = " + matrixText(k) +
                                " is not a camera matrix [fx s cx; 0 fy cy; 0 0 1] with positive fx and fy");
  }
}

}  // namespace corrsel::core
