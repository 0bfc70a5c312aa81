#pragma once

#include <opencv2/core/matx.hpp>
#include <optional>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Fits a fundamental matrix (px, Frobenius norm 1, rank 2) to matches that are all taken for correct, such
/// as points that people marked. Of 1000 random samples of seven (seed 0), the matrix with the smallest
/// median Sampson distance is the first one; steps of refineFundamental() over all matches follow while they
/// lower the sum of the squared distances.
/// @return nothing where the matches do not determine it: fewer than eight, or all in one plane
/// O(1000 N).
std::optional<cv::Matx33d> fitFundamental(const Correspondences& matches);

}  // namespace corrsel::core
