#pragma once

#include <cstdint>

namespace corrsel::core {

/// Conversion towards zero. Values that do not fit become -2^31 or 2^31 - 128, and NaN becomes 0: a plain
/// conversion is undefined for them, and differs between x86-64 and ARM.
inline std::int32_t saturated(float value) {
  constexpr float kMin = -2147483648.0F, kMax = 2147483520.0F;
  if (!(value > kMin)) return value <= kMin ? static_cast<std::int32_t>(kMin) : 0;
  return static_cast<std::int32_t>(value < kMax ? value : kMax);
}

}  // namespace corrsel::core
