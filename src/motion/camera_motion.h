#pragma once

#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <vector>

#include "corrsel/correspondences.h"
#include "corrsel/selection.h"
#include "geometry/normalization.h"
#include "geometry/rays.h"

namespace corrsel::core {

/// The motion of the camera that a selection states, and what contradicts it.
///
/// Kinds of motion:
///  - of points: the place of every static point in the right image is known. The camera is at rest, or its
///    pose is a rotation. It is at rest by its pose, and also where at least half of the selected matches are
///    displaced by at most 4 px, and the affine displacement that fits these is at most 1 px in all corners
///    of their bounding box. A fundamental matrix or a translation
///    is not determined then, and would explain an object.
///  - of a plane: a homography, which is that of a plane or of a turned camera.
///  - epipolar: a pose with translation, or a fundamental or essential matrix.
///
/// The error of a match is that of residual.h. A match whose right point lies on the wrong side of that of an
/// infinitely far point would be behind a camera; with a pose, its distance from there counts if it is
/// larger. The two poses of a plane count both: the smaller error is taken.
///
/// An error is beyond the noise if it exceeds 4 standard deviations, which are estimated from the median of
/// the static matches, or 3 px (points, planes) or 2 px (lines), whichever is more.
class CameraMotion {
 public:
  /// @param matches    with finite coordinates; they must outlive the calls
  /// @param selection  of select()
  /// @param base       per match: 1 = selected without belonging to another group than 0
  /// @return whether the selection states a motion of the camera
  bool assign(const Correspondences& matches, const Selection& selection,
              const std::vector<std::uint8_t>& base);

  /// Per match: whether its error is beyond the noise. Matches whose error is not known are not.
  const std::vector<std::uint8_t>& beyond() const { return beyond_; }

  /// Whether matches are contradicted by every motion of the camera that explains the static ones.
  /// @param group  rows of at least 8 matches
  bool contradicts(const std::vector<std::uint32_t>& group);

  /// Replaces the motion by another one where that explains more: a fundamental matrix that is fitted to the
  /// given matches. A large object in front of a scene with depth can be the strongest group, and the scene
  /// is then what contradicts it.
  /// @param others  rows of all matches in groups that contradict the motion
  /// @return whether it was replaced; never where there is a pose
  bool replaceBy(const std::vector<std::uint32_t>& others);

 private:
  enum class Kind : std::uint8_t { kNone, kPoints, kPlane, kEpipolar };

  Kind findErrors(const Selection& selection);
  bool atRest();
  void poseErrors(const Pose& pose, const RayMatches& rays, std::vector<double>& errors) const;
  void judge();
  void writeSampson(const cv::Matx33d& f, const std::vector<std::uint32_t>& rows,
                    std::vector<double>& errors) const;
  bool explainedTogether(const std::vector<std::uint32_t>& group);
  bool jointPoseErrors();
  bool jointFundamental(cv::Matx33d& f);

  const Correspondences* matches_ = nullptr;
  Kind kind_ = Kind::kNone;
  std::optional<Pose> pose_;  // with a translation
  double still_ = 0;          // kPoints: displacement that the static scene shows, px
  double limit_ = 0;          // of errors within the noise, px
  std::vector<std::uint32_t> base_, joint_;
  std::vector<double> errors_, others_;  // squared, px^2
  std::vector<std::uint8_t> beyond_;
  RayMatches rays_, joint_rays_;
  NormalizedMatches normalized_;
};

}  // namespace corrsel::core
