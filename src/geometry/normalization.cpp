#include "geometry/normalization.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include "base/gather.h"
#include "base/largest_magnitude.h"

namespace corrsel::core {
namespace {

void takeColumns(const float* from, std::size_t size, const std::vector<std::uint32_t>& rows,
                 std::vector<float>& to) {
  to.resize(kRayNumbers * rows.size());
  float* out = to.data();
  for (std::size_t k = 0; k < kRayNumbers; ++k)
    for (const std::uint32_t row : rows) *out++ = from[k * size + row];
}

void narrow(const Rays& from, const std::vector<std::uint32_t>& rows, std::vector<float>& to) {
  to.resize(kRayNumbers * rows.size());
  float* out = to.data();
  for (const std::vector<double>& column : from.column)
    for (const std::uint32_t row : rows) *out++ = static_cast<float>(column[row]);
}

void widenColumns(const float* from, std::size_t size, const std::vector<std::uint32_t>& rows, Rays& to) {
  to.resize(rows.size());
  for (std::size_t k = 0; k < kRayNumbers; ++k)
    for (std::size_t i = 0; i < rows.size(); ++i) to.column[k][i] = from[k * size + rows[i]];
}

}  // namespace

void RayColumns::take(const RayMatches& rays, const std::vector<std::uint32_t>& rows) {
  narrow(rays.left, rows, left);
  narrow(rays.right, rows, right);
  size = rows.size();
}

void RayColumns::take(const RayColumns& rays, const std::vector<std::uint32_t>& rows) {
  takeColumns(rays.left.data(), rays.size, rows, left);
  takeColumns(rays.right.data(), rays.size, rows, right);
  size = rows.size();
}

void RayColumns::widen(const std::vector<std::uint32_t>& rows, RayMatches& to) const {
  widenColumns(left.data(), size, rows, to.left);
  widenColumns(right.data(), size, rows, to.right);
}

void normalizeMatches(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                      NormalizedMatches& result) {
  std::vector<float>* const columns[4] = {&result.left_x, &result.left_y, &result.right_x, &result.right_y};
  const std::size_t n = rows.size();
  result.rays = {};
  for (std::vector<float>* column : columns) column->resize(n);
  float *const lx = result.left_x.data(), *const ly = result.left_y.data();
  float *const rx = result.right_x.data(), *const ry = result.right_y.data();
  double mean[4] = {0, 0, 0, 0}, spread = 0;
  // The four columns are copied and summed together, so that the additions do not wait for one another.
  for (std::size_t i = 0; i < n; ++i) {
    const std::uint32_t row = rows[i];
    mean[0] += lx[i] = matches.left_x[row];
    mean[1] += ly[i] = matches.left_y[row];
    mean[2] += rx[i] = matches.right_x[row];
    mean[3] += ry[i] = matches.right_y[row];
  }
  double largest = 0;
  for (const std::vector<float>* column : columns)
    largest = std::max<double>(largest, largestMagnitude(*column));
  for (double& value : mean) value = n == 0 ? 0.0 : value / static_cast<double>(n);
  double squares[4] = {0, 0, 0, 0};
  const auto square = [](double value) { return value * value; };
  for (std::size_t i = 0; i < n; ++i) {
    squares[0] += square(lx[i] - mean[0]);
    squares[1] += square(ly[i] - mean[1]);
    squares[2] += square(rx[i] - mean[2]);
    squares[3] += square(ry[i] - mean[3]);
  }
  for (const double sum : squares) spread += sum;
  const double rms = n == 0 ? 0.0 : std::sqrt(spread / (2.0 * static_cast<double>(n)));
  const double s = rms > 0 ? std::sqrt(2.0) / rms : 1.0;
  result.scale = s;
  // A multiple of the rounding of the pixel and of the normalised coordinate.
  result.rounding = 8.0 * std::numeric_limits<float>::epsilon() * s * largest;
  result.left = cv::Matx33d(s, 0, -s * mean[0], 0, s, -s * mean[1], 0, 0, 1);
  result.right = cv::Matx33d(s, 0, -s * mean[2], 0, s, -s * mean[3], 0, 0, 1);
  for (int c = 0; c < 4; ++c) {
    for (float& value : *columns[c]) value = static_cast<float>((value - mean[c]) * s);
  }
}

void takeRays(const Correspondences& matches, const RayMatches& rays, const std::vector<std::uint32_t>& rows,
              NormalizedMatches& result) {
  gather(matches.left_x, rows, result.left_x);
  gather(matches.left_y, rows, result.left_y);
  gather(matches.right_x, rows, result.right_x);
  gather(matches.right_y, rows, result.right_y);
  result.scale = 1;
  result.rounding = 0;
  result.left = result.right = cv::Matx33d::eye();
  result.rays.take(rays, rows);
}

NormalizedMatches normalizeMatches(const Correspondences& matches) {
  std::vector<std::uint32_t> rows(matches.size());
  std::iota(rows.begin(), rows.end(), 0U);
  NormalizedMatches result;
  normalizeMatches(matches, rows, result);
  return result;
}

cv::Matx33d NormalizedMatches::homographyToPixels(const cv::Matx33d& normalized) const {
  const cv::Matx33d back(1 / scale, 0, -right(0, 2) / scale, 0, 1 / scale, -right(1, 2) / scale, 0, 0, 1);
  const cv::Matx33d h = back * normalized * left;
  const double norm = cv::norm(h);
  const double last = h(2, 2);
  // Dividing by a negative element would reverse the sign of the third coordinate.
  const double divisor = last > 1e-12 * norm ? last : norm;
  return divisor > 0 ? h * (1.0 / divisor) : h;
}

cv::Matx33d NormalizedMatches::homographyFromPixels(const cv::Matx33d& pixels) const {
  const cv::Matx33d back(1 / scale, 0, -left(0, 2) / scale, 0, 1 / scale, -left(1, 2) / scale, 0, 0, 1);
  const cv::Matx33d h = right * pixels * back;
  const double norm = cv::norm(h);
  return norm > 0 ? h * (1.0 / norm) : h;
}

cv::Matx33d NormalizedMatches::fundamentalToPixels(const cv::Matx33d& normalized) const {
  const cv::Matx33d f = right.t() * normalized * left;
  const double norm = cv::norm(f);
  return norm > 0 ? f * (1.0 / norm) : f;
}

std::pair<double, double> rightExtent(const NormalizedMatches& matches) {
  const auto extent = [](const std::vector<float>& column) {
    const Eigen::Map<const Eigen::ArrayXf> values(column.data(), static_cast<Eigen::Index>(column.size()));
    return values.maxCoeff() - values.minCoeff();
  };
  return {extent(matches.right_x), extent(matches.right_y)};
}

}  // namespace corrsel::core
