#include "geometry/rays.h"

#include <algorithm>
#include <cmath>

#include "base/gather.h"
#include "geometry/lens.h"
#include "kernels/kernels.h"

namespace corrsel::core {

double Rays::pixelAngle(std::size_t i) const {
  double sum = 0;
  for (std::size_t k = 3; k < kColumns; ++k) sum += column[k][i] * column[k][i];
  return std::sqrt(0.5 * sum);
}

std::size_t unproject(const Camera& camera, const float* x, const float* y, std::size_t n, Rays& rays) {
  constexpr std::size_t kBlock = 256;  // pixels that are converted at a time
  const PreparedLens lens = prepareLens(camera);
  const auto kernel = kernels().rays.unproject[static_cast<std::size_t>(lens.kind)];
  rays.resize(n);
  std::array<double, kBlock> block_x, block_y;
  std::array<double*, Rays::kColumns> columns;
  std::size_t missing = 0;
  for (std::size_t begin = 0; begin < n; begin += kBlock) {
    const std::size_t size = std::min(kBlock, n - begin);
    std::copy_n(x + begin, size, block_x.begin());
    std::copy_n(y + begin, size, block_y.begin());
    for (std::size_t k = 0; k < Rays::kColumns; ++k) columns[k] = rays.column[k].data() + begin;
    missing += kernel(lens.model, block_x.data(), block_y.data(), size, columns.data());
  }
  return missing;
}

std::size_t unproject(const Correspondences& matches, RayMatches& rays, std::vector<std::uint8_t>& exists) {
  const std::size_t n = matches.size();
  const std::size_t left =
      unproject(*matches.left_camera, matches.left_x.data(), matches.left_y.data(), n, rays.left);
  const std::size_t right =
      unproject(*matches.right_camera, matches.right_x.data(), matches.right_y.data(), n, rays.right);
  exists.assign(n, 1);
  if (left + right == 0) return 0;
  std::size_t missing = 0;
  for (std::size_t i = 0; i < n; ++i) {
    exists[i] = std::isnan(rays.left.column[0][i]) || std::isnan(rays.right.column[0][i]) ? 0 : 1;
    missing += exists[i] == 0 ? 1 : 0;
  }
  return missing;
}

void gatherRays(const RayMatches& from, const std::vector<std::uint32_t>& rows, RayMatches& to) {
  for (std::size_t k = 0; k < Rays::kColumns; ++k) {
    gather(from.left.column[k], rows, to.left.column[k]);
    gather(from.right.column[k], rows, to.right.column[k]);
  }
}

}  // namespace corrsel::core
