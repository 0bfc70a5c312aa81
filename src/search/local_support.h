#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "base/coordinate_order.h"
#include "base/deadline.h"
#include "corrsel/correspondences.h"
#include "corrsel/neighbours.h"
#include "geometry/frame_map.h"
#include "kernels/kernels.h"
#include "points/point_cells.h"
#include "points/point_groups.h"

namespace corrsel::core {

/// Counts for every match the other matches that a local affine map through it predicts, and tests whether
/// there are more of them than chance explains.
///
/// Idea: one match fixes a local map x' = x'_i + A (x - x_i). Its frames give A; without frames, so does a
/// near second match, which is not tried where the frames give a sure map. Every good match is therefore a
/// hypothesis of its own, and no sample of several inliers has to be drawn.
///
/// Algorithm: hypotheses are made for the best matches. For the hypothesis (i, A), the predicted
/// displacement u_j = A (x_j - x_i) and the actual one v_j = x'_j - x'_i, radii R = D/16, D/8, D/4, D/2 (D is
/// the diagonal of the right image) and relative tolerances rho = 0.12 (noise of frames) and, for the two
/// smaller radii, 0.3 (affine part that a similarity lacks):
///
///   k      = sum of w_j over |u_j| <= R and |v_j - u_j| <= max(3 px, rho |u_j|)
///   n_l    = sum of w_j over |u_j| <= R,      n_r = sum of w_j over |v_j| <= R
///   lambda = n_l n_r / W * max(rho^2 / 2, (3 px)^2 / R^2) / s + 0.02
///   S_i    = max over R, rho of k ln(k / lambda) - (k - lambda), 0 where k <= lambda
///
/// The weight w_j is 1 / number of matches with the same right point, rounded to whole px, so that many left
/// features that share one right feature count once; W is the sum of all weights. s is the share of the disc
/// around x'_i that lies within the bounding box of the right points: the supporters have less room there
/// than in a full disc, so more of them agree by chance. Matches with |u_j| or |v_j| <= 3 px are left out,
/// because they are the same point again. S is the log likelihood ratio of a Poisson count.
///
/// Larger discs are looked at only where the smaller ones leave it open whether the map is right: not where S
/// is already more than twice what makes a survivor, nor where S is below 2 although the disc holds at least
/// 40 matches. Maps of inliers are sure, and those of outliers hopeless, mostly after D/8.
///
/// Hypotheses are made for the M = min(N, max(100, 10^6 / N)) best matches, without frames five for each of M
/// = min(N, max(60, 8 * 10^5 / N)), but for no more once 200 have survived, or 64 if these are 30 % of those
/// tried. Of the five, no more are tried once one is sure (S more than twice what makes a survivor). The M /
/// 4 best other matches outside of the extended local set are tried as well, so that small groups with a
/// motion of their own are found; the matches that these predict join the local sets.
///
/// Survivors have S_i > ln(6 N T) + 4, where T is 1 with frames and 5 without: 6 tests per hypothesis, and an
/// expected number of e^-4 survivors by chance. A match is in the local set if at least 5 of its 8 nearest
/// survivors in the left image predict it within max(3 px, 0.3 min(|u|, D/8)). The extended local set has
/// 0.45 in place of 0.3.
///
/// Input: coordinates; frames and image sizes where they are there; an order by quality.
///
/// Failure: where fewer than 5 matches survive, the local sets are empty. Degenerate input (all points equal,
/// frames that are singular or NaN) gives no support, and no error.
///
/// Sensitivity, as change of the F of `auto` on the real and generated datasets: lambda with N in place of W
/// and without s lets 34 to 39 outliers survive per pair of unrelated images (0 to 0.1 as it is). One
/// vote of 8 in place of 5 costs 1 to 17 on SymBench, tolerances that grow beyond D/8 cost 1 to 5 there, 6
/// votes cost 0.9 on AdelaideRMF, D/16 in place of D/8 costs 1.6 on KITTI. 2 or 6 in place of 4, and 100 or
/// any number in place of 200 survivors, change it by at most 0.6. rho = 0.10 or 0.15 in place of 0.12
/// changes single pairs (-4.5 to +1.5). Up to 2 M, 3 M or 4 M matches where few survive cost 2 on SymBench
/// with hessian_affine and gain up to 1.6 with sift. A least-squares refit of A to its supporters was tried
/// and gains nothing.
///
/// Cost: O(M n + N) where discs of D/8, with n matches each, decide; at most O(M N). Memory of about 150
/// bytes per match is kept between calls.
///
/// Source: own work. That one local frame is a hypothesis is common in instance recognition; the test against
/// the number expected by chance follows Moisan and Stival, IJCV 2004.
class LocalSupport {
 public:
  /// @param order    every row of `matches` once, best first; ties must not depend on the order of the input
  /// @param threads  that may be used, the caller's included; the results are the same for any number
  /// @param deadline after which no more hypotheses are verified
  /// @return false if the deadline has cut the work
  /// @pre all coordinates are finite
  bool compute(const Correspondences& matches, const std::vector<std::uint32_t>& order, int threads = 1,
               const Deadline& deadline = Deadline(0));

  /// S per row of the input; 0 where a match has no hypothesis or no support beyond chance.
  const std::vector<float>& support() const { return support_; }

  /// The linear part of the best map per row of the input. Members of the extended local set whose own
  /// support is not significant have the map of the nearest survivor that predicts them. Zero for all others
  /// whose support() is 0.
  const std::vector<LinearMap>& maps() const { return maps_; }

  /// Rows whose support is significant, by falling support.
  const std::vector<std::uint32_t>& survivors() const { return survivors_; }

  /// Per row: 1 if it belongs to the local set L.
  const std::vector<std::uint8_t>& local() const { return local_; }
  std::size_t localSize() const { return local_size_; }

  /// Per row: 1 if it belongs to the extended local set L2.
  const std::vector<std::uint8_t>& extended() const { return extended_; }

  /// Per row: its weight as a vote, in (0, 1].
  const std::vector<float>& weights() const { return weights_; }

  /// D: the diagonal of the right image, or of the bounding box of the right points where the size of the
  /// image is unknown, px.
  double diagonal() const { return diagonal_; }

  /// Area of the same, px^2; at least 1.
  double area() const { return area_; }

 private:
  static constexpr int kMaxPartners = 5, kDiscs = 4;
  static constexpr int kMaxRows = 64;  // of cells

  struct Bounds {
    std::array<double, 2> low, high;  ///< x and y, px
  };

  /// What the hypotheses of a match have in common, per disc.
  struct Place {
    std::int32_t right[kDiscs] = {-1, -1, -1, -1};  ///< n_r in units of 1 / unit_; -1: not known yet
    double visible[kDiscs] = {};                    ///< s; 0: not known yet
  };

  /// Columns of matches in the slots of a grid.
  struct Columns {
    std::vector<float> left_x, left_y, right_x, right_y;
    std::vector<std::int32_t> weight;

    void assign(const PointCells& cells);
    VotingMatches view() const;
  };

  static Bounds boundsOf(const std::vector<float>& x, const std::vector<float>& y, const cv::Size& image);
  CellGrid gridOver(const Bounds& bounds) const;
  void layOut(const Correspondences& matches);
  void findWeights();
  void sortPool(std::size_t verified);
  static int partnersPerMatch(bool frames) { return frames ? 1 : kMaxPartners; }
  /// Verifies the maps of the matches candidates_[first .. last), and adds the survivors to members_.
  void verifyBatch(const Correspondences& matches, bool frames, std::size_t first, std::size_t last,
                   int threads);
  bool frameMap(const Correspondences& matches, std::size_t rank, LinearMap& map) const;
  int partners(std::size_t rank, int wanted, std::uint32_t* out) const;
  double radius(int disc) const { return diagonal_ / (16 >> disc); }
  SupportRule ruleOf(int disc) const;
  double visibleShare(std::size_t rank, int disc, Place& place) const;
  /// Counts the supporters of a map through a match, and keeps the map if it is the match's best so far.
  /// @param partner  the second match that the map was made from, or nullptr
  void verify(std::size_t rank, const LinearMap& map, const std::uint32_t* partner, Place& place);
  void extendLocalSets();

  // Matches are numbered by their rank in the order of quality. The order of the input then has no influence.
  std::size_t n_ = 0;
  double diagonal_ = 0, area_ = 1, all_weights_ = 0, significant_support_ = 0;
  Bounds bounds_{};                                         // of the right points
  std::int32_t unit_ = 1;                                   // the weight of a match that counts fully
  std::vector<std::uint32_t> row_;                          // by rank
  std::vector<float> left_x_, left_y_, right_x_, right_y_;  // by rank
  std::vector<std::int32_t> weight_;                        // by rank
  PointCells left_cells_, right_cells_;
  Columns by_left_, by_right_;
  std::vector<float> best_;          // S by rank
  std::vector<LinearMap> best_map_;  // by rank
  std::vector<KeyedRow> pool_;       // matches that may be partners, by left x
  std::vector<float> pool_left_x_, pool_left_y_, pool_right_x_, pool_right_y_;  // in this order
  std::vector<std::uint32_t> candidates_;  // ranks that hypotheses are made for
  std::vector<std::uint32_t> members_, near_;
  std::vector<std::uint32_t> open_;  // ranks that are not in both sets yet
  std::vector<KeyedRow> scratch_;
  PointGroups right_points_;
  PlanarNeighbours neighbours_;

  std::vector<float> support_, weights_;
  std::vector<LinearMap> maps_;
  std::vector<std::uint32_t> survivors_;
  std::vector<std::uint8_t> local_, extended_;
  std::size_t local_size_ = 0;
};

}  // namespace corrsel::core
