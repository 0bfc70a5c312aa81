#include "geometry/rigid_motion.h"

#include <Eigen/Geometry>
#include <cmath>
#include <initializer_list>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "base/text.h"

namespace corrsel::core {
namespace {

constexpr double kRotationTolerance = 1e-2;

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

cv::Matx33d toMatrix(const Eigen::Quaterniond& quaternion) {
  const RowMajor rotation = quaternion.toRotationMatrix();
  return cv::Matx33d(rotation.data());
}

Eigen::Quaterniond toQuaternion(const cv::Matx33d& rotation) {
  const Eigen::Matrix3d matrix = Eigen::Map<const RowMajor>(rotation.val);
  return Eigen::Quaterniond(matrix);
}

std::string textOf(std::initializer_list<double> numbers) {
  std::vector<std::string> texts;
  for (const double number : numbers) texts.push_back(std::isnan(number) ? "nan" : formatNumber(number));
  return joinList(texts, " ");
}

void requireFinite(const cv::Vec3d& translation) {
  if (cv::checkRange(translation)) return;
  throw std::invalid_argument("the translation is " +
                              textOf({translation[0], translation[1], translation[2]}) +
                              ", which is not finite");
}

}  // namespace

RigidMotion RigidMotion::inverse() const { return {rotation.t(), -(rotation.t() * translation)}; }

RigidMotion operator*(const RigidMotion& first, const RigidMotion& second) {
  return {first.rotation * second.rotation, first.rotation * second.translation + first.translation};
}

RigidMotion motionOf(double w, double x, double y, double z, const cv::Vec3d& translation) {
  const Eigen::Quaterniond quaternion(w, x, y, z);
  const double square = quaternion.squaredNorm();
  if (!(square > 0 && std::isfinite(square))) {
    throw std::invalid_argument("the quaternion is " + textOf({w, x, y, z}) + ", which is no rotation");
  }
  requireFinite(translation);
  return {toMatrix(quaternion.normalized()), translation};
}

RigidMotion motionOf(const cv::Matx44d& matrix) {
  if (matrix(3, 0) != 0 || matrix(3, 1) != 0 || matrix(3, 2) != 0 || matrix(3, 3) != 1) {
    throw std::invalid_argument("its last row is not 0 0 0 1");
  }
  const cv::Matx33d written = matrix.get_minor<3, 3>(0, 0);
  const std::string fault =
      "its rotation is not one: the rows must be orthogonal, of length 1, and the "
      "determinant 1";
  if (!cv::checkRange(written) || cv::determinant(written) <= 0) throw std::invalid_argument(fault);
  cv::Matx31d values;
  cv::Matx33d u, vt;
  cv::SVD::compute(written, values, u, vt);
  const cv::Matx33d rotation = u * vt;
  if (cv::norm(rotation - written) > kRotationTolerance) throw std::invalid_argument(fault);
  const cv::Vec3d translation(matrix(0, 3), matrix(1, 3), matrix(2, 3));
  requireFinite(translation);
  return {rotation, translation};
}

RigidMotion interpolated(const RigidMotion& from, const RigidMotion& to, double share) {
  const Eigen::Quaterniond rotation = toQuaternion(from.rotation).slerp(share, toQuaternion(to.rotation));
  return {toMatrix(rotation), from.translation * (1 - share) + to.translation * share};
}

}  // namespace corrsel::core
