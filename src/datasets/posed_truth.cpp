#include "datasets/posed_truth.h"

#include <opencv2/core.hpp>

#include "corrsel/evaluation/pinhole_view.h"
#include "geometry/cross_matrix.h"

namespace corrsel::core {

GroundTruth truthOf(RelativePose pose, const Camera& left, const Camera& right) {
  pose.left_camera = pinholeOf(left);
  pose.right_camera = pinholeOf(right);
  GroundTruth truth;
  truth.pose = pose;
  const bool translated = cv::norm(pose.translation) > 0;
  if (left.isPlainPinhole() && right.isPlainPinhole()) {
    truth.kind = translated ? TruthKind::kFundamental : TruthKind::kHomography;
    truth.matrix =
        translated ? pose.fundamental() : pose.right_camera * pose.rotation * pose.left_camera.inv();
  } else {
    const cv::Matx33d essential = crossMatrix(pose.translation) * pose.rotation;
    truth.kind = translated ? TruthKind::kEssential : TruthKind::kRotation;
    truth.matrix = translated ? essential * (1 / cv::norm(essential)) : pose.rotation;
  }
  return truth;
}

}  // namespace corrsel::core
