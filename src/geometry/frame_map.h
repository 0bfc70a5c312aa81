#pragma once

#include <array>
#include <optional>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// The linear part of a local affine map, row-major.
using LinearMap = std::array<float, 4>;

/// The linear map A = right left^-1 that takes the left frame of a match to the right one.
/// @return nothing if a frame is not finite, has no area or is more than 10 times longer than wide, or if one
/// frame is a thousand times larger than the other
std::optional<LinearMap> frameMap(const AffineFrame& left, const AffineFrame& right);

/// The maps of all matches that have one.
/// @param maps  receives one map per match, zero where there is none
/// @param rows  receives the numbers of the matches that have a map
/// @pre both columns of frames
void findFrameMaps(const Correspondences& matches, std::vector<LinearMap>& maps,
                   std::vector<std::uint32_t>& rows);

}  // namespace corrsel::core
