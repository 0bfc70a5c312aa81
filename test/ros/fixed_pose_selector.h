#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::testing {

struct FixedPoseOptions : core::OptionSet {
  int motion = static_cast<int>(core::Motion::kGeneral);

  void visit(core::OptionVisitor& visitor) const override {
    visitor.integer({"motion", 0, 4, "-", "The verdict"}, &FixedPoseOptions::motion);
  }
};

/// Selects every match, and finds the same pose between any two images of calibrated cameras.
class FixedPoseSelector : public core::SelectorWithOptions<FixedPoseOptions> {
 public:
  static constexpr char kName[] = "fixed_pose";

  std::string name() const override { return kName; }

 protected:
  void run(const core::Correspondences& matches, core::Workspace&, core::Selection& result) const override {
    result.mask.assign(result.mask.size(), 1);
    result.confidence = 20;
    if (!matches.left_camera || !matches.right_camera) return;
    core::PoseResult pose;
    pose.motion = static_cast<core::Motion>(options_.motion);
    if (pose.motion == core::Motion::kGeneral) pose.pose.translation = {0, 0, 1};
    if (pose.motion != core::Motion::kNone) pose.covariance = 1e-6 * cv::Matx<double, 5, 5>::eye();
    pose.noise = 0.5;
    result.pose = pose;
  }
};

}  // namespace corrsel::testing
