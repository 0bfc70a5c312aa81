#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// What the two cameras see, see makeScene().
enum class MatchSceneKind : std::uint8_t {
  kPlane,
  kSpace,
  kRest,
  kRotation,
  kForward,
  kMovingObject,
  kPassingObject,
  kTwoPlanes,
  kWall,
  kFacade
};

/// Specification of generated matches between two images of 1024 x 768 px.
struct SceneSpec {
  MatchSceneKind kind = MatchSceneKind::kPlane;
  std::size_t n = 1000;
  double inlier_ratio = 0.5;
  std::uint64_t seed = 0;
  bool sorted = false;  ///< best ratio of descriptor distances first, as OpenCV's PROSAC requires
  double noise = 1;     ///< standard deviation of the localisation noise per coordinate, px
  double object_share =
      0.2;                ///< kMovingObject, kPassingObject: share of the left image that the object covers
  bool frames = true;     ///< whether matches have local affine frames
  bool distances = true;  ///< whether matches have descriptor distances
  bool sizes = true;      ///< whether the sizes of the images are stated
};

/// Generated matches with the mask of the correct ones.
struct MatchScene {
  Correspondences matches;               ///< in random order
  std::vector<std::uint8_t> inlier;      ///< one entry per match
  std::vector<std::uint8_t> structure;   ///< one entry per match: 0 outlier, 1 background, 2 moving object
  std::vector<cv::Point2f> left, right;  ///< the same points in OpenCV's types
};

/// Generates matches.
///
/// Kinds; the focal length is 900 px:
///  - kPlane: a homography (rotation 8 degrees, scale 0.92, small perspective).
///  - kSpace: two cameras side by side see points at random depths of 4 to 12.
///  - kRest: the camera does not move. With noise 0, the two images are identical.
///  - kRotation: the camera turns by 10 degrees about the vertical, 3 about the horizontal and 5 about the
///    optical axis.
///  - kForward: the camera moves by 1 along the optical axis of a corridor, whose walls are seen at depths of
///    4 to 20. The epipole is the image centre.
///  - kMovingObject: the camera moves sideways by 0.6 in that corridor. A rectangle in front of it covers
///    `object_share` of the left image, turns by 8 degrees, grows by a tenth, and moves by (-40, 60) px.
///    What it hides in one of the images has no match.
///  - kPassingObject: the same object in front of a camera at rest.
///  - kTwoPlanes: two cameras side by side see a corner of a building.
///  - kWall: two cameras side by side see a wall at depth 8, with points up to 1.5 in front of or behind it.
///  - kFacade: a plane with a lattice of equal windows, 80 px apart. Half of the outliers are
///    windows mistaken for one of their three next neighbours in the row, with the frames of inliers,
///    and all matches have ratios of descriptor distances around 0.85.
///
/// Noise: the right points have noise; for kSpace, the left ones too.
///
/// Frames: an inlier maps the left frame to the right one by the derivative of its motion. The noise of
/// this map is 10 % per element for kPlane, else 10 % of scale and 6 degrees of angle; it is zero where
/// `noise` is. Outliers have random similarities.
///
/// Outliers are uniform in both images. The ratios of descriptor distances are N(.60, .12) for inliers
/// and N(.78, .10) for outliers.
///
/// Columns left out do not change the others.
///
/// Cost: O(n / inlier_ratio).
MatchScene makeScene(const SceneSpec& spec);

/// The camera of both images of makeScene(). The matches do not carry it.
Camera sceneCamera();

}  // namespace corrsel::core
