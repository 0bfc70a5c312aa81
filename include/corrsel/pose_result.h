#pragma once

#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>

namespace corrsel::core {

/// How the right camera moved relative to the left one, as far as the matches show it. The texts returned by
/// toString() are part of the file formats.
enum class Motion : std::uint8_t {
  kNone = 0,      ///< no motion of a camera explains more matches than chance
  kRest = 1,      ///< moved the points by less than a pixel, or by less than the threshold if that is more
  kRotation = 2,  ///< turned; a translation does not show
  kGeneral = 3,   ///< translated, in a scene with depth
  kPlanar = 4     ///< translated before a plane, or before a scene whose depth does not show: two poses
};

std::string toString(Motion motion);

/// Throws std::invalid_argument listing the valid texts.
Motion motionFromString(const std::string& text);

/// A pose of the right camera relative to the left one, up to scale: a point X in the frame of the left
/// camera is R X + z t in that of the right one, with unknown z > 0.
struct Pose {
  cv::Matx33d rotation = cv::Matx33d::eye();  ///< R
  cv::Vec3d translation;                      ///< t: of length 1, or 0
};

/// What a calibrated selector found out about the motion between the images.
struct PoseResult {
  Motion motion = Motion::kNone;
  Pose pose;  ///< identity and 0 at rest and where there is none; t = 0 of a rotation
  /// Covariance of the pose, symmetric. The order is w1 w2 w3 a b: the true rotation is exp([w]_x) R, w in
  /// rad in the frame of the right camera, and the true translation is the direction of t + a b1 + b b2 (rad)
  /// with the vectors of translationBasis(). Where t is 0, the rows and columns of a and b are NaN, and all
  /// of it is NaN at kNone, and where it would not hold (see `uncertain`).
  cv::Matx<double, 5, 5> covariance = cv::Matx<double, 5, 5>::all(std::numeric_limits<double>::quiet_NaN());
  bool uncertain = false;  ///< whether outliers that agree by chance are so many that no covariance holds
  double noise = std::numeric_limits<double>::quiet_NaN();  ///< of each coordinate of a feature, px
  /// Root mean square of the displacements that the rotation does not explain, px; NaN at kNone.
  double parallax = std::numeric_limits<double>::quiet_NaN();
  /// kPlanar: the other pose that explains the plane, where the matches do not exclude it.
  std::optional<Pose> second;
};

/// Two directions orthogonal to the unit vector t and to each other, by which the covariance measures it:
/// b1 = t x e / |t x e| with the axis e of the smallest |t_i| (the first of equal ones), b2 = t x b1.
void translationBasis(const cv::Vec3d& t, cv::Vec3d& b1, cv::Vec3d& b2);

}  // namespace corrsel::core
