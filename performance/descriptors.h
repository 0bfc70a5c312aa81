#pragma once

#include <cstddef>
#include <string>

#include "measurement.h"

namespace corrsel::performance {

/// Descriptors of two views of a generated picture: smooth noise of all scales, 2000 x 1500 px, and its image
/// under a homography (rotation 10 degrees, scale 0.9) with noise of 2 grey levels. "sift" and "orb" are
/// those of OpenCV; "rootsift" is the square root of SIFT divided by its sum, whose values are not whole
/// numbers.
enum class DescriptorKind { kSift, kOrb, kRootSift };

/// core::findNeighbours() between `n` descriptors of each view. The bytes of its result are compared in place
/// of a mask.
Method neighbours(const std::string& name, DescriptorKind kind, std::size_t n, int threads);

/// cv::BFMatcher::knnMatch for two neighbours.
Method openCvNeighbours(DescriptorKind kind, std::size_t n, bool same_outcome);

}  // namespace corrsel::performance
