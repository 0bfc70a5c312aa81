#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/correspondences.h"
#include "corrsel/pose_result.h"
#include "corrsel/relative_pose.h"

namespace corrsel::core {

/// Cameras of generated scenes, one of each model:
///  - pinhole: 1280x960 px, f = 600 px, no distortion;
///  - rational: the same with the rational model and tangential distortion, which see 65 degrees from the
///  axis
///    in the corners;
///  - fisheye: 1280x960 px, f = 400 px, k1 = -0.02, k2 = 0.003, more than 180 degrees from corner to corner;
///  - equirectangular: 1280x640 px.
Camera scenePinhole();
Camera sceneRational();
Camera sceneFisheye();
Camera scenePanorama();

/// How the right camera of a generated scene has moved.
enum class SceneMotion : std::uint8_t {
  kRest,
  kRotation,
  kGeneral,  ///< turned, and translated in a random direction
  kForward,  ///< turned, and translated along the axis of the left camera, whose image contains the epipole
  kPlane     ///< like kGeneral, before a plane
};

std::string toString(SceneMotion motion);

struct CalibratedSceneSpec {
  Camera left_camera = scenePinhole(), right_camera = scenePinhole();
  SceneMotion motion = SceneMotion::kGeneral;
  std::size_t n = 400;
  double inlier_ratio = 0.7;
  double noise = 1;        ///< standard deviation of each coordinate in both images, px
  double baseline = 0.15;  ///< length of the translation, divided by the mean distance of the points
  std::uint64_t seed = 0;
  bool distances = true;  ///< whether matches have descriptor distances
};

/// Generated matches of calibrated cameras with their truth.
struct CalibratedScene {
  Correspondences matches;           ///< in random order, with cameras and the sizes of the images
  std::vector<std::uint8_t> inlier;  ///< one entry per match
  /// R, and t in units of the scene, 0 at kRest and kRotation; the camera matrices are those of pinholeOf().
  RelativePose pose;
  Motion motion = Motion::kNone;  ///< kRest, kRotation, kGeneral or, of a plane, kPlanar
};

/// Generates matches of points in space. The left points are uniform in their image. The points lie 4 to 12
/// along their rays, uniformly, or of kPlane on the plane n X = -8 with n = (a, b, -1), a and b normal with a
/// standard deviation of 0.4. The camera turns by 2 to 15 degrees about a random axis, except at rest. A
/// point that is not seen in both images is drawn again. The points of outliers are uniform in both images.
/// Descriptor distances are those of makeScene(). Same specification, same scene. O(n / inlier_ratio).
///
/// Throws std::invalid_argument for cameras without a size or that Camera::check() refuses.
CalibratedScene makeCalibratedScene(const CalibratedSceneSpec& spec);

}  // namespace corrsel::core
