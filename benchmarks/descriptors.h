#pragma once

#include <cstddef>
#include <string>

#include "measurement.h"

namespace corrsel::performance {

/// Descriptors of two views of a generated picture: smooth noise of all scales, 2000 x 1500 px, and its image
/// under a homography (rotation 10 degrees, scale 0.9) with noise of 2 grey levels. "sift" and "orb" are
/// those of OpenCV; "rootsift" the square roots of SIFT divided by its sum, which are not whole.
enum class DescriptorKind { kSift, kOrb, kRootSift };

/// core::findNeighbours() between `n` descriptors of each view; its outcome stands in for the mask, byte by
/// byte.
Method neighbours(const std::string& name, DescriptorKind kind, std::size_t n, int threads);

/// cv::BFMatcher::knnMatch for two neighbours.
Method openCvNeighbours(DescriptorKind kind, std::size_t n, bool same_outcome);

}  // namespace corrsel::performance
