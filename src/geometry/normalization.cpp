#include "corrsel/geometry/normalization.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace corrsel::core {
namespace {

double mean(const std::vector<float>& values) {
  double sum = 0;
  for (const float value : values) sum += value;
  return values.empty() ? 0.0 : sum / static_cast<double>(values.size());
}

double squaredSpread(const std::vector<float>& values, double centre) {
  double sum = 0;
  for (const float value : values) sum += (value - centre) * (value - centre);
  return sum;
}

double largestMagnitude(const std::vector<float>& values) {
  double largest = 0;
  for (const float value : values) largest = std::max(largest, static_cast<double>(std::abs(value)));
  return largest;
}

std::vector<float> shifted(const std::vector<float>& values, double centre, double scale) {
  std::vector<float> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    result[i] = static_cast<float>((values[i] - centre) * scale);
  return result;
}

}  // namespace

NormalizedMatches normalizeMatches(const Correspondences& matches) {
  NormalizedMatches result;
  const double lx = mean(matches.left_x), ly = mean(matches.left_y);
  const double rx = mean(matches.right_x), ry = mean(matches.right_y);
  const double spread = squaredSpread(matches.left_x, lx) + squaredSpread(matches.left_y, ly) +
                        squaredSpread(matches.right_x, rx) + squaredSpread(matches.right_y, ry);
  const double rms = matches.empty() ? 0.0 : std::sqrt(spread / (2.0 * static_cast<double>(matches.size())));
  if (rms > 0) result.scale = std::sqrt(2.0) / rms;
  const double s = result.scale;
  // Rounding of the pixel and of the normalised coordinate, some times over.
  result.rounding = 8.0 * std::numeric_limits<float>::epsilon() * s *
                    std::max({largestMagnitude(matches.left_x), largestMagnitude(matches.left_y),
                              largestMagnitude(matches.right_x), largestMagnitude(matches.right_y)});
  result.left = cv::Matx33d(s, 0, -s * lx, 0, s, -s * ly, 0, 0, 1);
  result.right = cv::Matx33d(s, 0, -s * rx, 0, s, -s * ry, 0, 0, 1);
  result.left_x = shifted(matches.left_x, lx, s);
  result.left_y = shifted(matches.left_y, ly, s);
  result.right_x = shifted(matches.right_x, rx, s);
  result.right_y = shifted(matches.right_y, ry, s);
  return result;
}

double triangleArea(const std::vector<float>& x, const std::vector<float>& y, std::uint32_t a,
                    std::uint32_t b, std::uint32_t c, double rounding) {
  const double bx = static_cast<double>(x[b]) - x[a], by = static_cast<double>(y[b]) - y[a];
  const double cx = static_cast<double>(x[c]) - x[a], cy = static_cast<double>(y[c]) - y[a];
  const double area = bx * cy - by * cx;
  const double error = rounding * (std::abs(bx) + std::abs(by) + std::abs(cx) + std::abs(cy));
  return std::abs(area) <= error ? 0.0 : area;
}

cv::Matx33d NormalizedMatches::homographyToPixels(const cv::Matx33d& normalized) const {
  const cv::Matx33d back(1 / scale, 0, -right(0, 2) / scale, 0, 1 / scale, -right(1, 2) / scale, 0, 0, 1);
  const cv::Matx33d h = back * normalized * left;
  const double norm = cv::norm(h);
  const double last = h(2, 2);
  // Dividing by a negative element would turn the sign of the third coordinate.
  const double divisor = last > 1e-12 * norm ? last : norm;
  return divisor > 0 ? h * (1.0 / divisor) : h;
}

cv::Matx33d NormalizedMatches::fundamentalToPixels(const cv::Matx33d& normalized) const {
  const cv::Matx33d f = right.t() * normalized * left;
  const double norm = cv::norm(f);
  return norm > 0 ? f * (1.0 / norm) : f;
}

}  // namespace corrsel::core
