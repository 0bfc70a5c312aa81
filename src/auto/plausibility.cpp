#include "auto/plausibility.h"

#include <algorithm>

#include "points/length_unit.h"

namespace corrsel::core {
namespace {

constexpr int kNearest = 8, kEnough = 2;
constexpr float kTolerance = 10.0F, kRelativeTolerance = 0.6F;  // units of the image, -

}  // namespace

void Plausibility::filter(const Correspondences& matches, const std::vector<LinearMap>& maps,
                          const std::vector<std::uint8_t>& core, std::vector<std::uint8_t>& mask) {
  members_.clear();
  for (std::uint32_t i = 0; i < matches.size(); ++i)
    if (core[i] != 0) members_.push_back(i);
  if (members_.size() < kEnough) return;
  neighbours_.build(matches.left_x.data(), matches.left_y.data(), members_.size(), kNearest, members_.data());
  const auto tolerance = kTolerance * static_cast<float>(LengthUnits::of(matches).right);
  std::uint32_t list[kNearest];
  for (std::uint32_t j = 0; j < matches.size(); ++j) {
    if (mask[j] == 0 || core[j] != 0) continue;
    const int found = neighbours_.nearest(matches.left_x[j], matches.left_y[j], kNearest, list);
    int votes = 0;
    for (int c = 0; c < found; ++c) {
      const std::uint32_t i = list[c];
      const LinearMap& a = maps[i];
      const float dx = matches.left_x[j] - matches.left_x[i], dy = matches.left_y[j] - matches.left_y[i];
      const float ux = a[0] * dx + a[1] * dy, uy = a[2] * dx + a[3] * dy;
      const float ex = matches.right_x[j] - matches.right_x[i] - ux;
      const float ey = matches.right_y[j] - matches.right_y[i] - uy;
      const float squared_tolerance =
          std::max(tolerance * tolerance, kRelativeTolerance * kRelativeTolerance * (ux * ux + uy * uy));
      votes += ex * ex + ey * ey <= squared_tolerance ? 1 : 0;
    }
    if (votes < kEnough) mask[j] = 0;
  }
}

}  // namespace corrsel::core
