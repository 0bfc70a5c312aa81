#include "corrsel/relative_pose.h"

#include <cmath>
#include <opencv2/core.hpp>  // inv()
#include <stdexcept>
#include <string>

#include "base/text.h"
#include "geometry/cross_matrix.h"

namespace corrsel::core {
namespace {

constexpr double kRotationTolerance = 1e-4;

template <int Rows, int Columns>
std::string text(const cv::Matx<double, Rows, Columns>& matrix) {
  std::string result;
  for (int row = 0; row < Rows; ++row) {
    for (int column = 0; column < Columns; ++column) {
      result += (row + column == 0 ? "" : column == 0 ? "; " : " ") + formatNumber(matrix(row, column));
    }
  }
  return "[" + result + "]";
}

template <int Rows, int Columns>
void requireFinite(const char* name, const cv::Matx<double, Rows, Columns>& matrix) {
  for (const double value : matrix.val) {
    if (!std::isfinite(value)) {
      throw std::invalid_argument(std::string(name) + " = " + text(matrix) + " is not finite");
    }
  }
}

void requireCamera(const char* name, const cv::Matx33d& k) {
  requireFinite(name, k);
  const bool form = k(1, 0) == 0 && k(2, 0) == 0 && k(2, 1) == 0 && k(2, 2) == 1;
  if (!form || !(k(0, 0) > 0) || !(k(1, 1) > 0)) {
    throw std::invalid_argument(std::string(name) + " = " + text(k) +
                                " is not a camera matrix [fx s cx; 0 fy cy; 0 0 1] with positive fx and fy");
  }
}

}  // namespace

void RelativePose::check() const {
  requireCamera("left_camera", left_camera);
  requireCamera("right_camera", right_camera);
  requireFinite("rotation", rotation);
  requireFinite("translation", translation);
  const double fault = cv::norm(rotation * rotation.t() - cv::Matx33d::eye());
  if (!(fault <= kRotationTolerance) || cv::determinant(rotation) < 0) {
    throw std::invalid_argument(
        "rotation = " + text(rotation) +
        " is not a rotation: its rows must be orthogonal, of length 1, and its determinant 1");
  }
}

cv::Matx33d RelativePose::fundamental() const {
  if (cv::norm(translation) == 0) {
    throw std::invalid_argument("translation = 0: a camera that only turned has no fundamental matrix");
  }
  const cv::Matx33d f = right_camera.inv().t() * crossMatrix(translation) * rotation * left_camera.inv();
  return f * (1.0 / cv::norm(f));
}

}  // namespace corrsel::core
