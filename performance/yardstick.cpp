#include "yardstick.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace corrsel::performance {

Mask yardstick(const core::Correspondences& m) {
  constexpr std::size_t kNeighbours = 12;
  constexpr float kAlike = 0.2F;
  const std::size_t n = m.size();
  std::vector<std::uint32_t> order(n);
  std::iota(order.begin(), order.end(), 0U);
  std::sort(order.begin(), order.end(), [&m](std::uint32_t a, std::uint32_t b) {
    return m.left_x[a] != m.left_x[b] ? m.left_x[a] < m.left_x[b] : a < b;
  });
  Mask mask(n, 0);
  for (std::size_t k = 0; k < n; ++k) {
    const std::uint32_t i = order[k];
    const std::size_t end = std::min(k + 1 + kNeighbours, n);
    float difference = 0;
    for (std::size_t next = k + 1; next < end; ++next) {
      const std::uint32_t j = order[next];
      const float dx = m.left_x[j] - m.left_x[i], dy = m.left_y[j] - m.left_y[i];
      const float du = m.right_x[j] - m.right_x[i], dv = m.right_y[j] - m.right_y[i];
      const float left = dx * dx + dy * dy, right = du * du + dv * dv;
      difference += std::sqrt((dx - du) * (dx - du) + (dy - dv) * (dy - dv)) / (left + right + 1);
    }
    mask[i] = difference < kAlike ? 1 : 0;
  }
  return mask;
}

}  // namespace corrsel::performance
