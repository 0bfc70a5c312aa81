#pragma once

#include <cstddef>
#include <cstdint>

#include "kernels/residual.h"

namespace corrsel::core {

/// 1 - exp(-z) for z >= 0, interpolated between the entries of a table.
struct SaturationTable {
  static constexpr int kPerUnit = 100, kMax = 16, kEntries = kPerUnit * kMax;
  float values[2 * kEntries];  ///< each value, and the step to the next one
};

/// How the cost of a match follows from its list of nearest matches, see LapSelector.
struct AreaRatioRule {
  static constexpr int kMaxCandidates = 60, kMaxNeighbours = 20;

  int candidates;       ///< length of the lists
  int neighbours;       ///< candidates whose motion agrees best
  int kept;             ///< number of the smallest deviations that the cost is the mean of
  float squared_floor;  ///< of the differences of motions, px^2
  const SaturationTable* saturation;

  /// Number of floats that the kernel needs as scratch memory.
  std::size_t scratchSize() const {
    constexpr std::size_t kMaxLanes = 16;
    const auto k = static_cast<std::size_t>(neighbours), pairs = k * (k - 1) / 2;
    return kMaxLanes * (4 * static_cast<std::size_t>(candidates) + 4 * k + 4 * pairs + pairs * (k - 2) / 3);
  }
};

/// The loop of local affine preservation.
struct AreaRatioKernels {
  /// Writes the costs of all matches.
  /// @param lists    list i begins at lists + i * stride
  /// @param scratch  rule.scratchSize() floats
  /// O(size (candidates neighbours + neighbours^3)).
  void (*costs)(const MatchColumns& matches, const std::uint32_t* lists, std::size_t stride,
                const AreaRatioRule& rule, float* scratch, float* costs);
};

}  // namespace corrsel::core
