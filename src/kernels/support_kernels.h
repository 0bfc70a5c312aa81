#pragma once

// Counts of the matches that agree with a local affine map.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

// The sum of this many weights of at most kOne fits into 32 bits.
constexpr std::size_t kSupportBlock = std::size_t{1} << 18;

inline IntV loadWeights(const std::int32_t* p) {
  IntV v;
  __builtin_memcpy(&v, p, sizeof v);
  return v;
}

inline void supportCountKernel(const VotingMatches& m, const LocalMap& map, const SupportRule& rule,
                               SupportCounts& counts) {
  constexpr int kRadii = SupportRule::kRadii, kCoarse = SupportRule::kCoarseRadii;
  for (std::size_t begin = 0; begin < m.size; begin += kSupportBlock) {
    const std::size_t end = begin + kSupportBlock < m.size ? begin + kSupportBlock : m.size;
    IntV left[kRadii] = {}, fine[kRadii] = {}, coarse[kCoarse] = {};
    for (std::size_t j = begin; j < end; j += kWidth) {
      const FloatV dx = load(m.left_x + j) - map.x, dy = load(m.left_y + j) - map.y;
      const FloatV vx = load(m.right_x + j) - map.u, vy = load(m.right_y + j) - map.v;
      const FloatV ux = map.a11 * dx + map.a12 * dy, uy = map.a21 * dx + map.a22 * dy;
      const FloatV ex = vx - ux, ey = vy - uy;
      const FloatV uu = ux * ux + uy * uy, vv = vx * vx + vy * vy, ee = ex * ex + ey * ey;
      const IntV weight = loadWeights(m.weight + j) & (minimum(uu, vv) > rule.squared_floor);
      const IntV is_fine = ee <= maximum(uu * rule.squared_rho[0], splat(rule.squared_floor));
      const IntV is_coarse = ee <= maximum(uu * rule.squared_rho[1], splat(rule.squared_floor));
#pragma GCC unroll 4
      for (int r = 0; r < kRadii; ++r) {
        const IntV in_disc = weight & (uu <= rule.squared_radius[r]);
        left[r] += in_disc;
        fine[r] += in_disc & is_fine;
        if (r < kCoarse) coarse[r] += in_disc & is_coarse;
      }
    }
    for (int r = 0; r < kRadii; ++r) {
      counts.left[r] += sum(left[r]);
      counts.fine[r] += sum(fine[r]);
      if (r < kCoarse) counts.coarse[r] += sum(coarse[r]);
    }
  }
}

inline void supportAroundKernel(const VotingMatches& m, float u, float v, const SupportRule& rule,
                                std::int64_t (&counts)[SupportRule::kRadii]) {
  constexpr int kRadii = SupportRule::kRadii;
  for (std::int64_t& count : counts) count = 0;
  for (std::size_t begin = 0; begin < m.size; begin += kSupportBlock) {
    const std::size_t end = begin + kSupportBlock < m.size ? begin + kSupportBlock : m.size;
    IntV inside[kRadii] = {};
    for (std::size_t j = begin; j < end; j += kWidth) {
      const FloatV vx = load(m.right_x + j) - u, vy = load(m.right_y + j) - v;
      const FloatV vv = vx * vx + vy * vy;
      const IntV weight = loadWeights(m.weight + j) & (vv > rule.squared_floor);
#pragma GCC unroll 4
      for (int r = 0; r < kRadii; ++r) inside[r] += weight & (vv <= rule.squared_radius[r]);
    }
    for (int r = 0; r < kRadii; ++r) counts[r] += sum(inside[r]);
  }
}

}  // namespace
}  // namespace corrsel::core
