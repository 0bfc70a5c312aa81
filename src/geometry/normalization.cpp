#include "corrsel/geometry/normalization.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace corrsel::core {
namespace {

/// Gathers a column. @return its largest magnitude
double gather(const std::vector<float>& column, const std::vector<std::uint32_t>& rows,
              std::vector<float>& out) {
  out.resize(rows.size());
  float largest = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    out[i] = column[rows[i]];
    largest = std::max(largest, std::abs(out[i]));
  }
  return largest;
}

}  // namespace

void normalizeMatches(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
                      NormalizedMatches& result) {
  std::vector<float>* const columns[4] = {&result.left_x, &result.left_y, &result.right_x, &result.right_y};
  const std::vector<float>* const from[4] = {&matches.left_x, &matches.left_y, &matches.right_x,
                                             &matches.right_y};
  double largest = 0;
  for (int c = 0; c < 4; ++c) largest = std::max(largest, gather(*from[c], rows, *columns[c]));
  const std::size_t n = rows.size();
  double mean[4] = {0, 0, 0, 0}, spread = 0;
  // The four columns side by side: their sums do not wait for one another.
  for (std::size_t i = 0; i < n; ++i) {
    for (int c = 0; c < 4; ++c) mean[c] += (*columns[c])[i];
  }
  for (double& value : mean) value = n == 0 ? 0.0 : value / static_cast<double>(n);
  double squares[4] = {0, 0, 0, 0};
  for (std::size_t i = 0; i < n; ++i) {
    for (int c = 0; c < 4; ++c) {
      const double offset = (*columns[c])[i] - mean[c];
      squares[c] += offset * offset;
    }
  }
  for (const double square : squares) spread += square;
  const double rms = n == 0 ? 0.0 : std::sqrt(spread / (2.0 * static_cast<double>(n)));
  const double s = rms > 0 ? std::sqrt(2.0) / rms : 1.0;
  result.scale = s;
  // Rounding of the pixel and of the normalised coordinate, some times over.
  result.rounding = 8.0 * std::numeric_limits<float>::epsilon() * s * largest;
  result.left = cv::Matx33d(s, 0, -s * mean[0], 0, s, -s * mean[1], 0, 0, 1);
  result.right = cv::Matx33d(s, 0, -s * mean[2], 0, s, -s * mean[3], 0, 0, 1);
  for (int c = 0; c < 4; ++c) {
    for (float& value : *columns[c]) value = static_cast<float>((value - mean[c]) * s);
  }
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
