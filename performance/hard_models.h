#pragma once

#include "report.h"

namespace corrsel::performance {

/// Searches for a homography among 2000 matches of which only a share of `inlier_ratio` is correct (1 px
/// noise), with at most 100000 samples at 3 px and confidence 0.99. `usac:h`, `ransac:h` and
/// cv::findHomography run one after the other on each of 100 scenes. There are no descriptor distances, so
/// that all of them sample uniformly. A model is found if at least 90 % of the true inliers lie within 3 px
/// of it.
/// @param peer_every  OpenCV, which takes seconds, runs on every scene whose number is a multiple of this
void runHardModels(double inlier_ratio, int peer_every, const std::string& name, Report& report);

}  // namespace corrsel::performance
