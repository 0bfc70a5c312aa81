#pragma once

#include <opencv2/core/matx.hpp>
#include <optional>

#include "corrsel/pose_prior.h"
#include "geometry/pose_fit.h"

namespace corrsel::core {

/// The rotation nearest to the given one that satisfies the prior: the known one, the given one after the
/// smallest turn that makes R left_down = right_down, or the given one if nothing is known.
cv::Matx33d constrained(const std::optional<PosePrior>& prior, const cv::Matx33d& rotation);

/// The directions in which a fit may move a pose that satisfies the prior; none of a rig.
PoseFreedom freedomOf(const std::optional<PosePrior>& prior);

}  // namespace corrsel::core
