#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "corrsel/correspondences.h"
#include "geometry/frame_map.h"

namespace corrsel::core {

/// Grows the local affine map of one match into an affine map between larger parts of the images.
///
/// Idea: near an inlier its local map predicts other inliers roughly. Fitting the map to them makes
/// it precise enough to predict matches that are farther away.
///
/// Algorithm: five rounds, with radii D/16, D/8, D/8, D/4 and D/4 (D is the diagonal of the right image) and
/// relative tolerances rho = 0.3, 0.25, 0.2, 0.15 and 0.12. The supporters of a round are the matches whose
/// predicted displacement u from the seed is at most the radius and whose error is at most
/// max(4 px, rho |u|). Where these are fewer than 4, the radius is doubled, up to D/2, and no later round
/// falls below the radius that was needed. An affine map is fitted to them by least squares, weighted by the
/// squared inverse of the tolerance and by the weights of the matches. With k supporters, 1 / (2 k) of the
/// mean diagonal of the normal matrix ties the linear part to that of the round before, because few
/// supporters close together determine it badly.
///
/// Failure: there is no map if a round has fewer than 4 supporters within D/2, or the last map fewer than 6.
///
/// Cost: O(N) per round; memory is kept between calls.
class AffineGrowing {
 public:
  struct Round {
    double radius;  ///< of the diagonal
    double rho;     ///< relative tolerance
  };

  /// @param matches   the memory must outlive the calls of grow()
  /// @param weights   votes per match
  /// @param diagonal  D, px
  void assign(const Correspondences& matches, const std::vector<float>& weights, double diagonal);

  /// @param seed    the match to start from
  /// @param linear  linear part of its local map
  /// @return whether map() is valid
  bool grow(std::uint32_t seed, const LinearMap& linear);

  /// The affine map as a homography, px.
  const cv::Matx33d& map() const { return map_; }

  /// The supporters of the last round, also after a failure.
  const std::vector<std::uint32_t>& supporters() const { return supporters_; }

 private:
  /// Displacement from the seed as a linear function of dx, dy and 1: pairs of coefficients for x and y.
  using Map = std::array<float, 6>;

  void findSupporters(const Round& round, double reach, const Map& map);

  const Correspondences* matches_ = nullptr;
  const float* weights_ = nullptr;
  double diagonal_ = 0;
  cv::Matx33d map_;
  std::uint32_t seed_ = 0;
  std::vector<std::uint32_t> supporters_, found_;
  std::vector<float> tolerances_;  // of the supporters, squared
};

}  // namespace corrsel::core
