#pragma once

#include <cstddef>
#include <string>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// What several selectors report in the same way about input that they cannot use.

/// Reports `degenerate` where all left or all right points are equal.
/// @return whether it did, and the selector must end
bool endsAtEqualPoints(const Correspondences& matches, Selection& result);

/// Reports `degenerate` where no match has usable frames, or where two or more matches have equal points in
/// an image. Otherwise the message states how many matches have no usable frames, if there are any.
/// @param usable  matches with usable frames, at most matches.size(), which must not be 0
/// @return whether the selector must end
bool endsAtFrames(const Correspondences& matches, std::size_t usable, Selection& result);

/// Why a selector that needs local affine frames cannot run: empty where the input is empty or has them.
std::string missingFrames(const Correspondences& matches, const std::string& selector);

}  // namespace corrsel::core
