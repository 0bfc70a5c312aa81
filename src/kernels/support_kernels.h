#pragma once

// Counts of the matches that agree with a local affine map.

#include "kernels/kernels.h"
#include "kernels/simd.h"

namespace corrsel::core {
namespace {

/// The first `radii` discs, with as many tolerances.
template <int radii>
void supportKernel(const VotingMatches& m, const SupportRun* runs, std::size_t count, const LocalMap& map,
                   const SupportRule& rule, SupportCounts& counts) {
  constexpr int tolerances = radii;
  IntV left[radii] = {}, supporters[radii][tolerances] = {};
  for (const SupportRun* run = runs; run != runs + count; ++run) {
    for (std::size_t j = run->begin; j < run->end; j += kWidth) {
      const FloatV dx = load(m.left_x + j) - map.x, dy = load(m.left_y + j) - map.y;
      const FloatV vx = load(m.right_x + j) - map.u, vy = load(m.right_y + j) - map.v;
      const FloatV ux = map.a11 * dx + map.a12 * dy, uy = map.a21 * dx + map.a22 * dy;
      const FloatV ex = vx - ux, ey = vy - uy;
      const FloatV uu = ux * ux + uy * uy, vv = vx * vx + vy * vy, ee = ex * ex + ey * ey;
      const IntV weight = load(m.weight + j) & (minimum(uu, vv) > rule.squared_floor);
      IntV predicted[tolerances];
#pragma GCC unroll 2
      for (int t = 0; t < tolerances; ++t)
        predicted[t] = ee <= maximum(uu * rule.squared_rho[t], splat(rule.squared_floor));
#pragma GCC unroll 2
      for (int r = 0; r < radii; ++r) {
        const IntV in_disc = weight & (uu <= rule.squared_radius[r]);
        left[r] += in_disc;
#pragma GCC unroll 2
        for (int t = 0; t < tolerances; ++t) supporters[r][t] += in_disc & predicted[t];
      }
    }
  }
  for (int r = 0; r < radii; ++r) {
    counts.left[r] = sum(left[r]);
    for (int t = 0; t < tolerances; ++t) counts.supporters[r][t] = sum(supporters[r][t]);
  }
}

template <int radii>
void aroundKernel(const VotingMatches& m, const SupportRun* runs, std::size_t count, float u, float v,
                  const SupportRule& rule, std::int32_t* counts) {
  IntV inside[radii] = {};
  for (const SupportRun* run = runs; run != runs + count; ++run) {
    for (std::size_t j = run->begin; j < run->end; j += kWidth) {
      const FloatV vx = load(m.right_x + j) - u, vy = load(m.right_y + j) - v;
      const FloatV vv = vx * vx + vy * vy;
      const IntV weight = load(m.weight + j) & (vv > rule.squared_floor);
#pragma GCC unroll 2
      for (int r = 0; r < radii; ++r) inside[r] += weight & (vv <= rule.squared_radius[r]);
    }
  }
  for (int r = 0; r < radii; ++r) counts[r] = sum(inside[r]);
}

inline void affineGainsKernel(const AffineMaps& maps, const MatchColumns& matches,
                              float inverse_squared_tolerance, float* gains) {
  static_assert(AffineMaps::kMaps == kLanes, "the maps are the lanes");
  for (int part = 0; part < kParts; ++part) {
    FloatV m[6], sum{};
#pragma GCC unroll 6
    for (int k = 0; k < 6; ++k) m[k] = load(maps.m[k] + part * kWidth);
    for (std::size_t j = 0; j < matches.size; ++j) {
      const float x = matches.left_x[j], y = matches.left_y[j];
      const FloatV ex = m[0] * x + m[1] * y + m[2] - matches.right_x[j];
      const FloatV ey = m[3] * x + m[4] * y + m[5] - matches.right_y[j];
      sum += maximum(1.0F - (ex * ex + ey * ey) * inverse_squared_tolerance, FloatV{});
    }
    store(gains + part * kWidth, sum);
  }
}

std::size_t supportersKernel(const MatchColumns& m, const GrowingMap& map, std::uint32_t* numbers,
                             float* tolerances) {
  std::size_t count = 0;
  const float* const p = map.p;
  IntV number = laneNumbers();
  for (std::size_t j = 0; j < m.size; j += kWidth, number += kWidth) {
    const float* columns[] = {m.left_x + j, m.left_y + j, m.right_x + j, m.right_y + j};
    float rest[4][kWidth] = {};
    if (m.size - j < kWidth) {
      for (int c = 0; c < 4; ++c) {
        __builtin_memcpy(rest[c], columns[c], (m.size - j) * sizeof(float));
        columns[c] = rest[c];
      }
    }
    const FloatV dx = load(columns[0]) - map.left_x, dy = load(columns[1]) - map.left_y;
    const FloatV ux = p[0] * dx + p[2] * dy + p[4], uy = p[1] * dx + p[3] * dy + p[5];
    const FloatV ex = load(columns[2]) - map.right_x - ux, ey = load(columns[3]) - map.right_y - uy;
    const FloatV length = ux * ux + uy * uy;
    const FloatV tolerance = maximum(length * map.squared_rho, splat(map.squared_floor));
    const IntV predicted = (length <= map.squared_radius) & (ex * ex + ey * ey <= tolerance) &
                           (number < static_cast<std::int32_t>(m.size));
    if (!anyTrue(predicted)) continue;
    keep(predicted, (IntV)tolerance, tolerances + count);
    count += keep(predicted, number, numbers + count);
  }
  return count;
}

}  // namespace
}  // namespace corrsel::core
