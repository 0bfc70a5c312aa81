#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "calibrated/plane_poses.h"
#include "calibrated/rotation_search.h"
#include "corrsel/pose_prior.h"
#include "corrsel/pose_result.h"
#include "geometry/normalization.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// What the decision about the motion is made from.
struct VerdictInput {
  const RayMatches& matches;  ///< the search set: one match per point, all rays exist, in random order
  const RayColumns& columns;  ///< the same in single precision
  const std::vector<std::uint32_t>* best_first;  ///< by quality; nullptr = unknown
  const Pose* pose;  ///< the refined pose of the essential matrix; nullptr if none was found
  double threshold;  ///< px
  std::uint64_t seed;
  std::optional<PosePrior> prior = std::nullopt;  ///< not of a rig, whose motion is known
};

struct Verdict {
  Motion motion = Motion::kNone;
  /// The best rotation; identity at rest. With a prior, one that satisfies it.
  cv::Matx33d rotation = cv::Matx33d::eye();
  double parallax = 0;         ///< root mean square displacement that the rotation does not explain, px
  Pose pose;                   ///< kPlanar: the better-fitting pose; kGeneral: that of the input
  std::optional<Pose> second;  ///< kPlanar: the other pose, unless the matches exclude it
};

/// Decides how the camera moved.
///
/// Idea: every rotation is an essential matrix with any t, and the two poses of a plane are those of one
/// homography. So a translation shows, and is the only one, where the essential matrix explains more than
/// the rotation or the homography does, and more than chance.
///
/// The unit of all widths is the threshold, but at least 4/3 of the noise of the errors of the pose: what
/// lies beyond 4 standard deviations is no inlier of a rotation, whatever the user's threshold is.
///
/// Algorithm: a simpler model M, the best rotation R or the homography R + t n^T of a plane, is compared with
/// the pose E. Errors of M are those of rotation_search.h; matches within 1.5 units agree with it.
///  - far: of the m matches with an error of M above 3 units, k agree with E and lie in front;
///    evidence = -log10 P(Bin(m, q) >= k), significant above 12: eight of these allow for the choice of E
///    among the solutions of many samples, and for its refinement. q is the share of re-paired matches that
///    agree and lie in front, at least 1e-3. Against R it is the mean over the m matches of the larger of
///    that and asin(min(1, threshold / error)) / pi, the chance of a feature that was found at another place
///    nearby, in any direction. The coarse levels of a pyramid find many such features.
///  - near: over the n matches within 3 units of M and 2.5 of E, with the sums of squares S_M and S_E and p
///    parameters of M, F = ((S_M - S_E) / (n + 5 - p)) / (S_E / (n - 5)). Significant where F > 1.3 and ln F
///    exceeds 5 standard deviations, sqrt(2 / (n + 5 - p) + 2 / (n - 5)). Before that, as many matches as may
///    be near M by chance are left out, those with the largest gain. F takes the noise for normal. Real noise
///    has heavier tails, and E aligns its largest errors with the epipolar lines. So against R the squared
///    errors along the lines must also exceed those across in common: with their differences g,
///    sum(g)^2 > min(49, n / 9) sum(g^2).
///
/// A model is real if at least 8 matches agree that are not all at one place, and the probability that so
/// many do by chance is below 1e-9 (E) or 1e-8 (R, in 1.5 or in 3 units; its q is at least 1e-3, too). A real
/// E shows a translation where far or near is significant against R, or R is not real. Then the motion is
/// kPlanar if neither is significant against the plane, otherwise kGeneral. Without a translation it is
/// kRotation if R is real, and kRest if R moves the points by less than a unit (root mean square), or by no
/// more than its own uncertainty. Otherwise it is kNone.
///
/// The pose of a plane is the one that has more of the matches in front, or, where both have nearly as many
/// (95 %), the one with the smaller loss on these. The other pose is reported, too, if its loss is below
/// 1 + 3 / sqrt(n) times that. They are fitted to 512 matches at most.
///
/// With a prior, R is the rotation nearest to the best one that satisfies it, E has fewer than five
/// parameters, and the pose of a plane is the only one, as the other one contradicts the prior in general.
///
/// Cost: O(N), 0.14 to 0.22 ms for 2000 matches, before a plane up to 0.29 ms. The memory is kept. Nothing
/// depends on the order of the input, if the matches are in random order.
///
/// Source: own work; analysis of variance for `near`, the binomial test of Moisan and Stival (IJCV 2004) for
/// `far`.
class MotionVerdict {
 public:
  Verdict decide(const VerdictInput& input);

 private:
  bool translates(const VerdictInput& input, const std::vector<float>& errors, int parameters);
  double chanceOfDisplaced(const VerdictInput& input, float error) const;
  bool isShared(std::vector<std::uint32_t>::const_iterator first, const std::vector<float>& errors) const;
  void measurePose(const VerdictInput& input);
  void measureNoise(const VerdictInput& input);
  void measureRotation(const VerdictInput& input, const cv::Matx33d& rotation);
  bool isReal(const VerdictInput& input, const std::vector<std::uint32_t>& agreeing, std::size_t sample_size,
              double chance, double decades) const;
  bool isAtRest(const VerdictInput& input, const cv::Matx33d& rotation) const;
  bool isInFront(const VerdictInput& input, std::size_t left, std::size_t right) const;
  double parallax(const cv::Matx33d& rotation, const std::vector<std::uint32_t>& rows);
  void decidePlane(const VerdictInput& input, Verdict& verdict);
  void choosePose(const Pose& other, Verdict& verdict);

  RayTransfer transfer_;
  RotationSearch rotations_;
  PlaneFit plane_;
  std::vector<float> pose_errors_, rotation_errors_, errors_;  // squared, px^2
  std::vector<std::uint8_t> agrees_;                           // with the pose, and lies in front
  std::vector<std::uint32_t> posed_, rotated_, rows_;          // of the matches that agree
  std::vector<std::uint32_t> near_rotation_;                   // within 3 units
  std::vector<std::uint32_t> near_;                            // of the matches near both models
  std::vector<double> wide_errors_;
  int parameters_ = 0;                            // of the pose
  double pose_chance_ = 1, rotation_chance_ = 1;  // share of re-paired matches that agree
  double near_rotation_chance_ = 1;
  double near_chance_ = 1;  // the latter, estimated, without a floor
  double noise_ = 0;        // of the errors of the pose, px
  double unit_ = 0;         // of all widths: the threshold, or more where the noise needs it, px
  RayMatches fitted_;
};

}  // namespace corrsel::core
