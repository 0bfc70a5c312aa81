#pragma once

#include "corrsel/camera.h"
#include "corrsel/ground_truth.h"
#include "corrsel/relative_pose.h"

namespace corrsel::core {

/// The ground truth of images whose cameras and pose are known. For pinholes without distortion it is the
/// fundamental matrix, or, of a camera that only turned, the homography K' R K^-1. For others it is the
/// essential matrix of the rays, with Frobenius norm 1, or the rotation.
/// @param pose  its camera matrices are replaced by those of pinholeOf()
GroundTruth truthOf(RelativePose pose, const Camera& left, const Camera& right);

}  // namespace corrsel::core
