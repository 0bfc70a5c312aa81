#pragma once

#include <array>
#include <optional>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// The linear part of a local affine map, row-major.
using LinearMap = std::array<float, 4>;

/// The linear map that takes the left frame of a match to the right one: R L^-1 with the 2x2 parts of the
/// frames. Nothing where a frame is not finite, has no area or is more than 10 times longer than wide, or
/// where one frame is more than 1000 times larger than the other.
std::optional<LinearMap> frameMap(const AffineFrame& left, const AffineFrame& right);

}  // namespace corrsel::core
