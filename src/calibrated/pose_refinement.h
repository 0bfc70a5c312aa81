#pragma once

#include <cstdint>
#include <vector>

#include "calibrated/chance_agreements.h"
#include "corrsel/pose_result.h"
#include "geometry/normalization.h"
#include "geometry/pose_fit.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// Refines a pose on all matches that agree with it.
///
/// Algorithm: the Geman-McClure loss, with the threshold as its scale, is minimised over the matches
/// within 2.5 thresholds that lie in front (geometry/pose_fit.h). Then the matches are gathered again, up to
/// 5 times. From the second time on, those that may agree by chance are left out (chance_agreements.h). A
/// pose with which less than 0.9 of the matches agree that agreed before is not taken.
///
/// Cost: O(N) per round. The memory is kept.
class PoseRefinement {
 public:
  /// @param matches    in random order, and the same in single precision; must outlive the object's use
  /// @param threshold  px
  /// @param robust     whether agreements by chance are left out
  /// @param candidates per match, whether it may take part, for example because it has local support;
  ///                   nullptr = all
  /// @param freedom    directions in which the pose may move; without any it is only measured
  /// @return false if the candidates do not determine the pose, which is then unchanged
  bool refine(const RayMatches& matches, const RayColumns& columns, double threshold, bool robust,
              const std::vector<std::uint8_t>* candidates, const PoseFreedom& freedom, Pose& pose);

  /// Rows of the candidates within the threshold and in front, under the last pose, ascending.
  const std::vector<std::uint32_t>& agreeing() const { return agreeing_; }

  /// Rows of the matches of the last fit, these matches, and the squared errors under the last pose, px^2.
  const std::vector<std::uint32_t>& rows() const { return rows_; }
  const RayMatches& fitted() const { return fitted_; }
  const std::vector<double>& errors() const { return errors_; }

  const ChanceAgreements& chance() const { return chance_; }

 private:
  void measure(const Pose& pose, const RayMatches& matches, double threshold,
               const std::vector<std::uint8_t>* candidates);
  void gather(const Pose& pose, const RayMatches& matches, bool robust);

  std::size_t n_candidates_ = 0;
  std::vector<double> errors_;
  std::vector<std::uint32_t> agreeing_, near_, rows_;  // within the threshold, within 2.5 of it, in the fit
  RayMatches fitted_;
  ChanceAgreements chance_;
};

}  // namespace corrsel::core
