#include "ros/bags/rig_truth.h"

#include <stdexcept>

#include "corrsel/ros/cameras.h"
#include "datasets/posed_truth.h"

namespace corrsel {
namespace {

// A calibration is more accurate than the tolerance of other readings, at which a declaration that moves
// points by a few pixels would make little difference.
constexpr double kTolerance = 2.0;  // px

void place(const std::vector<cv::Point2f>& points, std::vector<float>& x, std::vector<float>& y) {
  for (const cv::Point2f& point : points) {
    x.push_back(point.x);
    y.push_back(point.y);
  }
}

/// The points in the images that `to` would have made of the same recorded images.
core::Correspondences moved(const StereoRig& from, const StereoRig& to,
                            const core::Correspondences& matches) {
  core::Correspondences result;
  place(to.positionsLeft(from.recordedLeft(pointsOf(matches.left_x, matches.left_y))), result.left_x,
        result.left_y);
  place(to.positionsRight(from.recordedRight(pointsOf(matches.right_x, matches.right_y))), result.right_x,
        result.right_y);
  result.left_size = to.leftArea().size();
  result.right_size = to.rightArea().size();
  return result;
}

}  // namespace

core::GroundTruth truthOf(const StereoRig& rig) {
  core::GroundTruth truth;
  truth.kind = core::TruthKind::kFundamental;
  truth.matrix = rig.fundamental();
  truth.pose = rig.pose();
  return truth;
}

std::optional<RawRig> rawRigOf(const RigCamera& left, const RigCamera& right) {
  if (left.rectified || right.rectified) return std::nullopt;
  try {
    RawRig rig{cameraOf(left.info, false), cameraOf(right.info, false), {}};
    const auto isFisheye = [](const core::Camera& camera) {
      return camera.model == core::Camera::Model::kFisheye;
    };
    if (!isFisheye(rig.left) && !isFisheye(rig.right)) return std::nullopt;
    const std::optional<RigPose> pose = rigOf(left.info, false, right.info, false);
    if (!pose) return std::nullopt;
    core::RelativePose relative;
    relative.rotation = pose->rotation;
    relative.translation = pose->translation;
    rig.truth = core::truthOf(relative, rig.left, rig.right);
    return rig;
  } catch (const std::invalid_argument&) {  // StereoRig says what is wrong with the calibration
    return std::nullopt;
  }
}

std::vector<cv::Point2f> pointsOf(const std::vector<float>& x, const std::vector<float>& y) {
  std::vector<cv::Point2f> points;
  points.reserve(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) points.emplace_back(x[i], y[i]);
  return points;
}

std::vector<core::OtherReading> otherDeclarations(const RigCamera& left, const RigCamera& right,
                                                  const std::shared_ptr<const StereoRig>& rig) {
  std::vector<core::OtherReading> readings;
  for (const bool rectified : {false, true}) {
    if (left.rectified == rectified && right.rectified == rectified) continue;
    try {
      const auto other = std::make_shared<const StereoRig>(RigCamera{left.info, rectified, left.name},
                                                           RigCamera{right.info, rectified, right.name});
      readings.push_back(
          {rectified ? "rectified" : "raw", truthOf(*other),
           [rig, other](const core::Correspondences& matches) { return moved(*rig, *other, matches); },
           kTolerance});
    } catch (const std::invalid_argument&) {  // the declaration cannot be meant
    }
  }
  return readings;
}

}  // namespace corrsel
