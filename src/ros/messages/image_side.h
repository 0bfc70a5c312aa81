#pragma once

#include <cstdint>

namespace corrsel {

/// px; OpenCV reads images up to this.
constexpr std::uint32_t kMaxImageSide = 1u << 20;

}  // namespace corrsel
