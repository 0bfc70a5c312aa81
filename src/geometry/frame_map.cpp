#include "geometry/frame_map.h"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace corrsel::core {
namespace {

constexpr double kMaxAnisotropy = 10;  // of a frame, longer by shorter axis
constexpr double kMaxMagnification = 1000;

/// Whether the ellipse has an area and is not too long. With singular values s1 >= s2:
/// s1^2 + s2^2 = |F|^2 and s1 s2 = |det F|.
bool isUsable(const AffineFrame& f) {
  const double a = f[0], b = f[1], c = f[3], d = f[4];
  const double area = std::abs(a * d - b * c);
  return area > 0 && a * a + b * b + c * c + d * d <= (kMaxAnisotropy + 1 / kMaxAnisotropy) * area;
}

}  // namespace

std::optional<LinearMap> frameMap(const AffineFrame& left, const AffineFrame& right) {
  if (!isUsable(left) || !isUsable(right)) return std::nullopt;
  const double a = left[0], b = left[1], c = left[3], d = left[4], det = a * d - b * c;
  const double magnification = std::abs((right[0] * double{right[4]} - right[1] * double{right[3]}) / det);
  const double limit = kMaxMagnification * kMaxMagnification;
  if (!(magnification <= limit && magnification >= 1 / limit)) return std::nullopt;
  LinearMap map;
  for (std::size_t row = 0; row < 2; ++row) {
    const double p = right[3 * row], q = right[3 * row + 1];
    map[2 * row] = static_cast<float>((p * d - q * c) / det);
    map[2 * row + 1] = static_cast<float>((q * a - p * b) / det);
  }
  return map;
}

void findFrameMaps(const Correspondences& matches, std::vector<LinearMap>& maps,
                   std::vector<std::uint32_t>& rows) {
  maps.assign(matches.size(), LinearMap{});
  rows.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i) {
    const std::optional<LinearMap> map = frameMap(matches.left_frame[i], matches.right_frame[i]);
    if (!map) continue;
    maps[i] = *map;
    rows.push_back(i);
  }
}

}  // namespace corrsel::core
