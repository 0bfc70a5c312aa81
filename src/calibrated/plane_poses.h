#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "calibrated/rotation_search.h"
#include "corrsel/pose_result.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// Fits a plane to the points of a pose.
///
/// Algorithm: the inverse depth of a point along its left ray d is mu = n . d on the plane n . X = 1, in
/// units of the baseline: d' ~ R d + mu t, so that mu = |R d x d'|^2 / z with the scaled depth z. An error of
/// mu moves the right ray across by |t x p| / |p|^2 with p = R d + mu t, which gives its weight. n comes from
/// 100 random triples, scored on the first 128 matches, and least squares over the matches within 2
/// thresholds, three times.
///
/// Cost: O(N), 0.03 ms for 512 matches. The memory is kept.
class PlaneFit {
 public:
  /// @param rows  of the matches that agree with the pose and lie in front, in random order
  /// @param normal  receives n
  /// @return false with fewer than 3 matches, and where all triples are degenerate
  bool find(const Pose& pose, const RayTransfer& transfer, const std::vector<std::uint32_t>& rows,
            double threshold, std::uint64_t seed, cv::Vec3d& normal);

 private:
  void measure(const Pose& pose, const RayTransfer& transfer, const std::vector<std::uint32_t>& rows);
  bool drawTriples(double threshold, std::uint64_t seed, cv::Vec3d& normal);
  void refine(double threshold, cv::Vec3d& normal) const;

  std::size_t size_ = 0;
  std::vector<float> columns_;  // d x y z, mu, px per unit of mu
};

/// The pose besides the given one that a plane allows, refined.
/// @param normal    of the plane, see PlanePose
/// @param matches   that agree with the given pose
/// @return nothing where it is the same pose
std::optional<Pose> otherPoseOfPlane(const Pose& pose, const cv::Vec3d& normal, const RayMatches& matches,
                                     double threshold);

/// The homography R + t n^T between unit rays.
cv::Matx33d homographyOf(const Pose& pose, const cv::Vec3d& normal);

}  // namespace corrsel::core
