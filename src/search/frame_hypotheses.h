#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <vector>

#include "base/coordinate_order.h"
#include "corrsel/correspondences.h"
#include "search/seed_growing.h"

namespace corrsel::core {

/// Affine maps between the images, each of which was found from the local affine frames of a single match.
///
/// Idea: the frames of one match fix a map of the whole image, x' = x'_i + A_i (x - x_i), roughly. No sample
/// of several inliers has to be drawn, which is hopeless where few matches are inliers.
///
/// Algorithm: with tol = 2 % of the diagonal of the right image, every match scores
///   s_i = sum over 500 matches of max(0, 1 - |x'_i + A_i (x_j - x_i) - x'_j|^2 / tol^2).
/// The 500 are the best ones by descriptor distance, or random ones without distances. Matches are then taken
/// by falling score, and their maps are grown (search/affine_growing.h). A match that supports a map
/// that was grown before is passed over.
///
/// Failure: there is no map where no match has usable frames (geometry/frame_map.h), or where nothing grows.
///
/// Sensitivity, as F of `usac` with `sampler` = `frames` on SymBench (sift, orb,
/// hessian_affine; 68.9, 58.3, 58.2 as it is) and VGG (sift, orb; 91.1, 91.6): tol of 1 %: SymBench -1.6,
/// +0.3, -2.2; 500 random matches: SymBench -0.1, -1.9, -1.6. With two least-squares fits of an affine map in
/// place of growing, SymBench gains 1.7 with sift and loses 2.7 with hessian_affine, and VGG loses 2 to 3,
/// because a strong perspective is not found.
///
/// Cost: O(500 H) for the H = min(N, 3000) matches that are scored, and that of growing for each map.
///
/// Source: Philbin, Chum, Isard, Sivic and Zisserman, CVPR 2007 (fast spatial matching), for the idea that
/// each match proposes a map.
class FrameHypotheses {
 public:
  /// Scores the matches.
  /// @param matches     with frames; other columns are not used
  /// @param rows        those that take part, in random order
  /// @param best_first  positions in `rows`, best first; nullptr = all alike
  void assign(const Correspondences& matches, const std::vector<std::uint32_t>& rows,
              const std::vector<std::uint32_t>* best_first);

  /// Grows the map of the next match. @return false if there is none left
  bool next() { return growing_.next(); }

  /// The map that next() has grown, as a homography in pixels; nullptr where nothing has grown.
  const cv::Matx33d* map() const { return growing_.map(); }

 private:
  void sortSeeds(const std::vector<std::uint32_t>* best_first);

  Correspondences taking_part_, sample_;  // coordinates
  std::vector<float> weights_;
  double diagonal_ = 0;               // of the right image, px
  std::vector<LinearMap> maps_;       // per match
  std::vector<std::uint32_t> seeds_;  // matches that have a map, by falling score
  std::vector<KeyedRow> order_, scratch_;
  SeedGrowing growing_;
};

}  // namespace corrsel::core
