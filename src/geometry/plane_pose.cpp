#include <Eigen/Dense>
#include <cmath>
#include <opencv2/core.hpp>

#include "geometry/pose_fit.h"

namespace corrsel::core {
namespace {

constexpr double kMinDifference = 1e-9;  // of a homography from a rotation

using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

cv::Vec3d column(const Eigen::Matrix3d& matrix, int k) { return {matrix(0, k), matrix(1, k), matrix(2, k)}; }

cv::Matx33d columns(const cv::Vec3d& a, const cv::Vec3d& b, const cv::Vec3d& c) {
  return {a[0], b[0], c[0], a[1], b[1], c[1], a[2], b[2], c[2]};
}

/// Whether most of the matches have d'. H d < 0.
bool isReversed(const cv::Matx33d& homography, const RayMatches& matches) {
  std::size_t reversed = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    reversed += matches.right.direction(i).dot(homography * matches.left.direction(i)) < 0 ? 1 : 0;
  }
  return 2 * reversed > matches.size();
}

/// Whether more of the left rays meet the plane behind the camera.
bool isBehind(const cv::Vec3d& normal, const RayMatches& matches) {
  std::size_t behind = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    behind += matches.left.direction(i).dot(normal) < 0 ? 1 : 0;
  }
  return 2 * behind > matches.size();
}

}  // namespace

bool posesOfPlane(const cv::Matx33d& homography, const RayMatches& matches, PlanePose (&poses)[2]) {
  const Eigen::Matrix3d given = Eigen::Map<const RowMajor>(homography.val);
  if (!given.allFinite()) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(given.transpose() * given);
  const Eigen::Vector3d& values = solver.eigenvalues();  // ascending
  if (!(values[0] > 1e-24 * values[2])) return false;
  const double largest = values[2] / values[1], smallest = values[0] / values[1];
  if (!(largest - smallest > kMinDifference)) return false;
  const double scale = 1 / std::sqrt(values[1]);
  const cv::Matx33d h = homography * (isReversed(homography, matches) ? -scale : scale);
  const cv::Vec3d v1 = column(solver.eigenvectors(), 2), v2 = column(solver.eigenvectors(), 1),
                  v3 = column(solver.eigenvectors(), 0);
  for (int k = 0; k < 2; ++k) {
    const double first = std::sqrt(std::max(0.0, (1 - smallest) / (largest - smallest)));
    const double second = std::sqrt(std::max(0.0, (largest - 1) / (largest - smallest)));
    const cv::Vec3d u = v1 * first + v3 * (k == 0 ? second : -second);
    cv::Vec3d normal = v2.cross(u);
    const cv::Matx33d w = columns(h * v2, h * u, (h * v2).cross(h * u));
    poses[k].pose.rotation = w * columns(v2, u, normal).t();
    if (isBehind(normal, matches)) normal = -normal;
    const cv::Vec3d t = (h - poses[k].pose.rotation) * normal;
    poses[k].pose.translation = cv::normalize(t);
    poses[k].normal = normal * cv::norm(t);
  }
  return true;
}

}  // namespace corrsel::core
