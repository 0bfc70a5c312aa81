#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/pose_result.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// What the decision about the motion is made from.
struct VerdictInput {
  const RayMatches& matches;                     ///< the search set: one match per point, all rays exist
  const std::vector<std::uint32_t>* best_first;  ///< by quality; nullptr = unknown
  const Pose* pose;  ///< the refined pose of the essential matrix; nullptr if none was found
  double threshold;  ///< px
  std::uint64_t seed;
};

struct Verdict {
  Motion motion = Motion::kNone;
  cv::Matx33d rotation = cv::Matx33d::eye();  ///< the best rotation; identity at rest
  double parallax = 0;         ///< root mean square displacement that the rotation does not explain, px
  double displacement = 0;     ///< root mean square displacement from the identity, px
  std::size_t rotated = 0;     ///< matches that agree with the rotation
  std::size_t planar = 0;      ///< kPlanar: matches on the plane
  Pose pose;                   ///< kPlanar: the better-fitting pose; kGeneral: that of the input
  std::optional<Pose> second;  ///< kPlanar
};

/// Decides how the camera moved.
Verdict decideMotion(const VerdictInput& input);

}  // namespace corrsel::core
