#pragma once

#include <cstddef>

#include "corrsel/camera.h"
#include "kernels/unproject.h"

namespace corrsel::core {

/// A camera, prepared for its kernel.
struct PreparedLens {
  LensModel model;
  LensKind kind;
};

/// Chooses the kernel and finds where the distortion turns. A few microseconds where the lens has distortion.
PreparedLens prepareLens(const Camera& camera);

}  // namespace corrsel::core
