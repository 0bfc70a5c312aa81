#include "pose.h"

#include <algorithm>
#include <numeric>
#include <opencv2/calib3d.hpp>
#include <stdexcept>

#include "corrsel/camera.h"

namespace corrsel::performance {
namespace {

using core::Camera;

constexpr double kConfidence = 0.999;  // the default of cv::findEssentialMat
constexpr double kLeastDepth = 0.1;  // of unit rays: points further from the axis have no place in a pinhole

/// Where a camera with the identity as its matrix would see the point. @return false where it would not
bool undistort(const Camera& camera, cv::Point2d& point) {
  core::Ray ray;
  if (!core::unproject(camera, point, ray) || ray.direction[2] < kLeastDepth) return false;
  point = {ray.direction[0] / ray.direction[2], ray.direction[1] / ray.direction[2]};
  return true;
}

SortedMatches undistorted(const core::Correspondences& matches) {
  const SortedMatches all = sortedMatches(matches);
  SortedMatches result;
  for (std::size_t i = 0; i < all.rows.size(); ++i) {
    cv::Point2d left = all.left[i], right = all.right[i];
    if (!undistort(*matches.left_camera, left) || !undistort(*matches.right_camera, right)) continue;
    result.left.push_back(left);
    result.right.push_back(right);
    result.rows.push_back(all.rows[i]);
  }
  return result;
}

/// The matches that agree with the essential matrix and lie in front of both cameras.
std::vector<char> selectByOpenCv(const SortedMatches& matches, int method, double threshold) {
  const cv::Matx33d identity = cv::Matx33d::eye();
  cv::Mat mask, rotation, translation;
  const cv::Mat found =
      cv::findEssentialMat(matches.left, matches.right, identity, method, kConfidence, threshold, mask);
  std::vector<char> selected(matches.rows.size(), 0);
  if (found.rows < 3) return selected;
  cv::recoverPose(found.rowRange(0, 3), matches.left, matches.right, identity, rotation, translation, mask);
  for (std::size_t i = 0; i < selected.size(); ++i) selected[i] = mask.at<std::uint8_t>(int(i)) != 0;
  return selected;
}

}  // namespace

Method pose(const CalibratedSceneSpec& scene, std::size_t scenes, const core::OptionMap& options) {
  Method method = selector("pose", {}, scenes, options);
  method.setScene(scene);
  return method;
}

Method openCvPose(const std::string& name, const CalibratedSceneSpec& scene, std::size_t scenes, int method) {
  Method result{name, {}, scenes, [method](const std::vector<Scene>& inputs) -> Call {
                  if (method < 0) throw std::runtime_error("not run, needs OpenCV 4.5");
                  std::vector<SortedMatches> points;
                  for (const Scene& input : inputs) points.push_back(undistorted(input.matches));
                  const double threshold = kPoseThreshold / inputs[0].matches.left_camera->matrix(0, 0);
                  return [=, &inputs](std::size_t k) {
                    return points[k].maskOf(selectByOpenCv(points[k], method, threshold),
                                            inputs[k].matches.size());
                  };
                }};
  result.setScene(scene);
  return result;
}

Mask SortedMatches::maskOf(const std::vector<char>& selected, std::size_t n) const {
  Mask mask(n, 0);
  for (std::size_t i = 0; i < selected.size(); ++i) mask[rows[i]] = selected[i] != 0;
  return mask;
}

SortedMatches sortedMatches(const core::Correspondences& matches) {
  SortedMatches result;
  result.rows.resize(matches.size());
  std::iota(result.rows.begin(), result.rows.end(), std::size_t{0});
  if (!matches.distance.empty() && !matches.second_distance.empty()) {
    std::stable_sort(result.rows.begin(), result.rows.end(), [&](std::size_t a, std::size_t b) {
      return matches.distance[a] * matches.second_distance[b] <
             matches.distance[b] * matches.second_distance[a];
    });
  }
  for (const std::size_t row : result.rows) {
    result.left.emplace_back(matches.left_x[row], matches.left_y[row]);
    result.right.emplace_back(matches.right_x[row], matches.right_y[row]);
  }
  return result;
}

}  // namespace corrsel::performance
