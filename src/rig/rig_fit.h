#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "calibrated/pose_refinement.h"
#include "corrsel/pose_result.h"
#include "geometry/normalization.h"
#include "geometry/pose_fit.h"
#include "geometry/rays.h"
#include "rig/rig_window.h"

namespace corrsel::core {

/// The pose that the matches of a window show.
struct RigEstimate {
  Pose pose;
  cv::Matx<double, 5, 5> covariance;  ///< order of PoseResult::covariance
  /// The same with errors that the matches of a region have in common.
  cv::Matx<double, 5, 5> cautious;
  double noise;  ///< of the errors, px
};

/// Fits the pose of a rig to the matches of a window, see RigMonitor. Keeps its memory between calls.
class RigFit {
 public:
  /// @param start  of length-1 translation
  /// @return nothing if the matches do not determine a pose, or one more than 20 degrees from the start
  std::optional<RigEstimate> fit(const RigWindow& window, const Pose& start);

 private:
  void gather(const RigWindow& window);
  double noise(const Pose& pose, double q, double of_normal);
  std::optional<double> approach(Pose& pose);
  bool addCommonNoise(const Pose& pose, double scale, const std::vector<std::uint32_t>& groups,
                      cv::Matx<double, 5, 5>& covariance) const;
  double slope(double scale) const;

  RayMatches all_;                              // in random order
  std::vector<std::uint32_t> pairs_, regions_;  // of each match
  RayColumns columns_;
  std::vector<double> errors_;  // squared, px^2
  PoseRefinement refinement_;
};

}  // namespace corrsel::core
