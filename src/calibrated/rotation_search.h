#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "geometry/normalization.h"

namespace corrsel::core {

/// Squared errors of rays under linear maps, px^2: |d - d'|^2 / (s^2 + s'^2) for the direction d of M times
/// the left ray, the right ray d' and the pixel angles s, s'. Both components of an inlier's error have the
/// variance of the noise of one coordinate.
class RayTransfer {
 public:
  /// @param columns  must outlive the object's use
  void assign(const RayColumns& columns);

  std::size_t size() const { return columns_->size; }
  const RayColumns& columns() const { return *columns_; }
  /// Pixel angles of match i, rad.
  float leftAngle(std::size_t i) const { return left_angle_[i]; }
  float rightAngle(std::size_t i) const { return right_angle_[i]; }
  /// 1 / (s^2 + s'^2) of match i, rad^-2.
  float weight(std::size_t i) const { return weight_[i]; }

  /// Errors under a rotation of the first n matches.
  void rotationErrors(const cv::Matx33d& rotation, std::size_t n, float* out) const;
  /// Errors under a rotation of the left rays i with the right rays (i + shift) mod N: those of outliers.
  void repairedErrors(const cv::Matx33d& rotation, std::size_t shift, float* out) const;
  /// Errors under a homography between rays, of positive sign. The homography scales the noise of the left
  /// ray, so that the error e has the covariance s'^2 I + s^2 B B^T with the derivative B of its direction,
  /// and e^T (...)^-1 e is its square (a first-order Sampson error).
  void homographyErrors(const cv::Matx33d& homography, float* out) const;

 private:
  const RayColumns* columns_ = nullptr;
  std::vector<float> left_angle_, right_angle_, weight_;
};

/// Searches the rotation R with which the most rays agree, d' = R d.
///
/// Algorithm: candidates are the identity, a given rotation, and those of pairs of matches: triads of the
/// normalised sum, the normalised cross product and their product, left and right (Black, A passive system
/// for determining the attitude of a satellite, 1964). Every second pair is drawn from a growing prefix of
/// the best matches, where an order is known. Pairs whose angles differ in both images are skipped. At most
/// 100 candidates are scored by the truncated sum of errors of the first 256 matches, and given up as soon as
/// the sum passes the best one, or where hardly any of the first 64 agree. The best one is refined by
/// Procrustes' method with Geman-McClure weights (Arun, Huang and Blostein, PAMI 1987), first on these
/// matches and then on all.
///
/// Cost: 0.05 to 0.1 ms for 2000 matches. The memory is kept.
class RotationSearch {
 public:
  /// @param transfer    of matches in random order
  /// @param best_first  by quality; nullptr = unknown
  /// @param given       a candidate; nullptr = none
  /// @param threshold   error within which a match agrees, px
  /// @pre there are at least 2 matches
  cv::Matx33d find(const RayTransfer& transfer, const std::vector<std::uint32_t>* best_first,
                   const cv::Matx33d* given, double threshold, std::uint64_t seed);

 private:
  void takeSample(const RayTransfer& transfer);
  std::int64_t cost(const cv::Matx33d& rotation) const;
  void consider(const cv::Matx33d& rotation);
  void drawPairs(const std::vector<std::uint32_t>* best_first, double threshold, std::uint64_t seed);
  void refine(std::size_t n, int rounds, double threshold);

  const RayTransfer* transfer_ = nullptr;
  std::size_t sample_size_ = 0;  // multiple of the block
  std::vector<float> sample_;    // left, right, weight over the squared limit: 7 columns
  std::vector<float> errors_;
  cv::Matx33d best_;
  std::int64_t best_cost_ = 0;
};

}  // namespace corrsel::core
