#pragma once

// Counts of the matches that agree with a local affine map.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

inline void supportCountKernel(const VotingMatches& m, const LocalMap& map, const SupportRule& rule,
                               SupportCounts& counts) {
  constexpr int kRadii = SupportRule::kRadii;
  // The sum of this many weights of at most kOne fits into 32 bits.
  constexpr std::size_t kBlock = std::size_t{1} << 18;
  for (std::size_t begin = 0; begin < m.size; begin += kBlock) {
    const std::size_t end = begin + kBlock < m.size ? begin + kBlock : m.size;
    IntV left[kRadii] = {}, right[kRadii] = {}, fine[kRadii] = {}, coarse[kRadii] = {};
    for (std::size_t j = begin; j < end; j += kWidth) {
      const FloatV dx = load(m.left_x + j) - map.x, dy = load(m.left_y + j) - map.y;
      const FloatV vx = load(m.right_x + j) - map.u, vy = load(m.right_y + j) - map.v;
      const FloatV ux = map.a11 * dx + map.a12 * dy, uy = map.a21 * dx + map.a22 * dy;
      const FloatV ex = vx - ux, ey = vy - uy;
      const FloatV uu = ux * ux + uy * uy, vv = vx * vx + vy * vy, ee = ex * ex + ey * ey;
      IntV weight;
      __builtin_memcpy(&weight, m.weight + j, sizeof weight);
      weight &= (uu > rule.squared_floor) & (vv > rule.squared_floor);
      const IntV is_fine = ee <= maximum(uu * rule.squared_rho[0], splat(rule.squared_floor));
      const IntV is_coarse = ee <= maximum(uu * rule.squared_rho[1], splat(rule.squared_floor));
#pragma GCC unroll 4
      for (int r = 0; r < kRadii; ++r) {
        const IntV in_left = weight & (uu <= rule.squared_radius[r]);
        left[r] += in_left;
        right[r] += weight & (vv <= rule.squared_radius[r]);
        fine[r] += in_left & is_fine;
        coarse[r] += in_left & is_coarse;
      }
    }
    for (int r = 0; r < kRadii; ++r) {
      counts.left[r] += sum(left[r]);
      counts.right[r] += sum(right[r]);
      counts.supporters[0][r] += sum(fine[r]);
      counts.supporters[1][r] += sum(coarse[r]);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
