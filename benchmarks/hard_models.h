#pragma once

#include "report.h"

namespace corrsel::performance {

/// Searches a homography among 2000 matches of which only a share of `inlier_ratio` is correct (1 px noise),
/// with at most 100000 samples at 3 px and confidence 0.99: `usac:h`, `ransac:h` and cv::findHomography, one
/// after the other on every scene, 100 scenes. No descriptor distances: all sample uniformly. Found = the
/// returned model puts at least 90 % of the true inliers within 3 px.
/// @param peer_every  OpenCV, which takes seconds, gets every so many scenes
void runHardModels(double inlier_ratio, int peer_every, const std::string& name, Report& report);

}  // namespace corrsel::performance
