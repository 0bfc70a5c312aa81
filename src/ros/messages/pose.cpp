#include "corrsel/ros/pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>

#include "ros/messages/vectors.h"

namespace corrsel {
namespace {

using Matrix3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using Matrix5 = Eigen::Matrix<double, 5, 5, Eigen::RowMajor>;
using Matrix6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kLengthTolerance = 1e-3;  // of quaternions and directions that were written as text

[[noreturn]] void refuse(const std::string& field, const std::string& what) {
  throw std::invalid_argument("RelativePose message: " + field + " " + what);
}

/// The quaternion of a rotation whose w is not negative.
geometry_msgs::Quaternion quaternionMsg(const cv::Matx33d& rotation) {
  Eigen::Quaterniond q(Matrix3(Eigen::Map<const Matrix3>(rotation.val)));
  q.normalize();
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  geometry_msgs::Quaternion msg;
  msg.x = sign * q.x();
  msg.y = sign * q.y();
  msg.z = sign * q.z();
  msg.w = sign * q.w();
  return msg;
}

geometry_msgs::Quaternion noQuaternion() {
  geometry_msgs::Quaternion msg;
  msg.x = msg.y = msg.z = msg.w = kNaN;
  return msg;
}

cv::Matx33d readRotation(const std::string& field, const geometry_msgs::Quaternion& msg) {
  const Eigen::Quaterniond q(msg.w, msg.x, msg.y, msg.z);
  if (!(std::abs(q.norm() - 1.0) <= kLengthTolerance)) {
    refuse(field, "has the length " + std::to_string(q.norm()) + ", expected a unit quaternion");
  }
  cv::Matx33d rotation;
  Eigen::Map<Matrix3>(rotation.val) = q.normalized().toRotationMatrix();
  return rotation;
}

/// @param is_zero  whether the motion has no translation
cv::Vec3d readDirection(const std::string& field, const geometry_msgs::Vector3& msg, bool is_zero) {
  const cv::Vec3d t(msg.x, msg.y, msg.z);
  const double length = cv::norm(t);
  if (is_zero && length == 0) return t;
  if (is_zero || !(std::abs(length - 1.0) <= kLengthTolerance)) {
    refuse(field, "has the length " + std::to_string(length) + ", expected " + (is_zero ? "0" : "1"));
  }
  return t / length;
}

void requireNotNegative(const std::string& field, double number) {
  if (number < 0 || std::isinf(number)) {
    refuse(field, "is " + std::to_string(number) + ", expected a number from 0, or NaN");
  }
}

/// Fills in a pose that is estimated, or nothing at kNone.
void writeEstimate(const core::PoseResult& result, RelativePose& msg) {
  const cv::Vec3d none = cv::Vec3d::all(kNaN);
  const bool known = result.motion != core::Motion::kNone;
  msg.rotation = known ? quaternionMsg(result.pose.rotation) : noQuaternion();
  msg.translation = vectorMsg(known ? result.pose.translation : none);
  std::copy_n(result.covariance.val, msg.covariance.size(), msg.covariance.begin());
  msg.uncertain = result.uncertain;
  msg.has_second = result.second.has_value();
  msg.second_rotation = result.second ? quaternionMsg(result.second->rotation) : noQuaternion();
  msg.second_translation = vectorMsg(result.second ? result.second->translation : none);
  msg.scale_known = false;
  msg.scale = kNaN;
}

void writeRig(const RigPose& rig, RelativePose& msg) {
  const double scale = cv::norm(rig.translation);
  msg.rotation = quaternionMsg(rig.rotation);
  msg.translation = vectorMsg(rig.translation / scale);
  msg.covariance.fill(0.0);
  msg.uncertain = false;
  msg.has_second = false;
  msg.second_rotation = noQuaternion();
  msg.second_translation = vectorMsg(cv::Vec3d::all(kNaN));
  msg.scale_known = true;
  msg.scale = scale;
}

void writeBasis(RelativePose& msg) {
  const cv::Vec3d t(msg.translation.x, msg.translation.y, msg.translation.z);
  cv::Vec3d a = cv::Vec3d::all(kNaN), b = a;
  if (cv::norm(t) > 0) core::translationBasis(t, a, b);
  msg.basis_a = vectorMsg(a);
  msg.basis_b = vectorMsg(b);
}

/// The covariance of the inverse pose in ROS's order, see poseOfRight().
/// @param known  whether the covariance holds; false: nothing is known
/// @param scale  length of the translation, m; NaN = unknown
Matrix6 inverseCovariance(const core::PoseResult& result, bool known, double scale) {
  const Eigen::Map<const Matrix5> given(result.covariance.val);
  const Eigen::Map<const Matrix3> rotation(result.pose.rotation.val);
  const Eigen::Map<const Eigen::Vector3d> t(result.pose.translation.val);
  Matrix6 covariance = Matrix6::Zero();
  covariance.diagonal().setConstant(kUnknownVariance);
  const Eigen::Matrix3d turned = given.topLeftCorner<3, 3>();
  if (!known || !turned.allFinite()) return covariance;
  const Eigen::Matrix3d back = rotation.transpose();
  covariance.bottomRightCorner<3, 3>() = back * turned * back.transpose();
  if (t.isZero() || !given.allFinite()) return covariance;

  cv::Vec3d a, b;
  core::translationBasis(result.pose.translation, a, b);
  Eigen::Matrix3d cross;  // [t]x
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  Eigen::Matrix<double, 6, 5> jacobian = Eigen::Matrix<double, 6, 5>::Zero();
  jacobian.topLeftCorner<3, 3>() = -back * cross;
  jacobian.block<3, 1>(0, 3) = -back * Eigen::Map<const Eigen::Vector3d>(a.val);
  jacobian.block<3, 1>(0, 4) = -back * Eigen::Map<const Eigen::Vector3d>(b.val);
  if (!std::isnan(scale)) jacobian *= scale;
  jacobian.bottomLeftCorner<3, 3>() = -back;
  covariance = jacobian * given * jacobian.transpose();
  if (!std::isnan(scale)) return covariance;
  const Eigen::Vector3d along = back * t;
  covariance.topLeftCorner<3, 3>() += kUnknownVariance * along * along.transpose();
  return covariance;
}

/// Throws std::invalid_argument that names a field which holds nonsense.
void requireSense(const RelativePose& msg) {
  if (msg.status > Selection::STATUS_UNCERTAIN) {
    refuse("status", "is " + std::to_string(msg.status) + ", which is unknown");
  }
  if (msg.motion > RelativePose::MOTION_PLANAR) {
    refuse("motion", "is " + std::to_string(msg.motion) + ", which is unknown");
  }
  requireNotNegative("noise", msg.noise);
  requireNotNegative("parallax", msg.parallax);
  requireNotNegative("scale", msg.scale);
  if (msg.scale_known != 0 && !(msg.scale > 0)) {
    refuse("scale", "is " + std::to_string(msg.scale) + ", but scale_known is set");
  }
}

}  // namespace

RelativePose toPoseMsg(const core::Selection& selection, const PairInfo& info, const std::string& selector) {
  const core::PoseResult& result = *selection.pose;
  RelativePose msg;
  msg.header = info.header;
  msg.right_stamp = info.right_stamp;
  msg.right_frame_id = info.right_frame_id;
  msg.selector = selector;
  msg.status = static_cast<std::uint8_t>(selection.status);
  msg.confidence = selection.confidence;
  msg.motion = static_cast<std::uint8_t>(result.motion);
  msg.noise = result.noise;
  msg.parallax = result.parallax;
  if (info.rig) {
    writeRig(*info.rig, msg);
  } else {
    writeEstimate(result, msg);
  }
  writeBasis(msg);
  return msg;
}

core::PoseResult fromMsg(const RelativePose& msg, PairInfo* info) {
  requireSense(msg);
  core::PoseResult result;
  result.motion = static_cast<core::Motion>(msg.motion);
  const bool translates = result.motion == core::Motion::kGeneral || result.motion == core::Motion::kPlanar ||
                          msg.scale_known != 0;
  if (result.motion != core::Motion::kNone || msg.scale_known != 0) {
    result.pose.rotation = readRotation("rotation", msg.rotation);
    result.pose.translation = readDirection("translation", msg.translation, !translates);
  }
  std::copy(msg.covariance.begin(), msg.covariance.end(), result.covariance.val);
  result.uncertain = msg.uncertain != 0;
  result.noise = msg.noise;
  result.parallax = msg.parallax;
  if (msg.has_second != 0) {
    result.second = core::Pose{readRotation("second_rotation", msg.second_rotation),
                               readDirection("second_translation", msg.second_translation, false)};
  }
  if (info != nullptr) {
    info->header = msg.header;
    info->right_stamp = msg.right_stamp;
    info->right_frame_id = msg.right_frame_id;
    info->rig.reset();
    if (msg.scale_known != 0) {
      info->rig = RigPose{result.pose.rotation, msg.scale * result.pose.translation};
    }
  }
  return result;
}

std::optional<geometry_msgs::PoseWithCovarianceStamped> poseOfRight(const RelativePose& msg) {
  const core::PoseResult result = fromMsg(msg);
  const bool usable = msg.status == Selection::STATUS_OK || msg.status == Selection::STATUS_TIME_LIMIT;
  if (!usable || result.motion == core::Motion::kNone) return {};
  const double scale = msg.scale_known != 0 ? msg.scale : kNaN;
  const cv::Matx33d back = result.pose.rotation.t();
  const cv::Vec3d position = back * result.pose.translation * (std::isnan(scale) ? -1.0 : -scale);
  geometry_msgs::PoseWithCovarianceStamped pose;
  pose.header = msg.header;
  pose.pose.pose.position.x = position[0];
  pose.pose.pose.position.y = position[1];
  pose.pose.pose.position.z = position[2];
  pose.pose.pose.orientation = quaternionMsg(back);
  const bool known = !result.uncertain && !result.second;
  Eigen::Map<Matrix6>(pose.pose.covariance.data()) = inverseCovariance(result, known, scale);
  return pose;
}

}  // namespace corrsel
