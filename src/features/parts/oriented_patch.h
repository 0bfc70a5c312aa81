#pragma once

#include <cstdint>
#include <vector>

#include "features/parts/image_pyramid.h"

namespace corrsel::core {

/// A direction in the image.
struct PatchDirection {
  float angle;         ///< degrees in [0, 360)
  float cosine, sine;  ///< of the angle
};

/// The direction of a patch of a pyramid level, and its descriptor by rotated BRIEF.
///
/// Idea: The vector from a corner to the intensity centroid of its surroundings turns with the image. Tests
/// that turn with it give the same bits in a rotated image.
///
/// Algorithm: The direction is that of (sum x I, sum y I) over a disc with a radius of patch_size / 2. The
/// places of kOrbPattern are scaled with the patch, turned by the direction rounded to one of kDirections,
/// and rounded to pixels, once for all patches. A descriptor has the results of the tests on the blurred
/// level.
///
/// Cost: a few hundred ns per patch.
///
/// Source: Rublee, Rabaud, Konolige and Bradski, ICCV 2011, sections 3.2 and 4.
class OrientedPatch {
 public:
  /// Of the turned tests, 3 degrees apart. With 12 degrees as in the paper, the share of inliers on
  /// VGG's pairs is 0.9 points lower.
  static constexpr int kDirections = 120;
  static constexpr int kBytes = 32;  ///< of a descriptor

  /// @param patch_size  px of the level; a patch has 2 (patch_size / 2) + 1 px to each side
  explicit OrientedPatch(int patch_size);

  int radius() const { return radius_; }

  /// The direction of the patch around a pixel. A patch whose centroid is its centre has the angle 0.
  /// @pre the patch lies inside the level
  PatchDirection direction(const PyramidLevel& level, int x, int y) const;

  /// Writes the kBytes bytes of the patch around a pixel; test i is bit i % 8 of byte i / 8.
  /// @param blurred  see ImagePyramid::blurred()
  /// @pre the patch lies inside the blurred part of the level
  void describe(const PyramidLevel& blurred, int x, int y, float angle, std::uint8_t* out) const;

  /// The place of a test, turned and rounded as describe() does it.
  static cv::Point turned(double x, double y, int direction);

  /// The number of the direction that is nearest to an angle in degrees.
  static int numberOf(float angle);

 private:
  int radius_, blocks_;
  std::vector<std::int8_t> x_weights_, y_weights_;  ///< of the moments
  std::vector<std::uint16_t> places_;               ///< of the tests, per direction
};

/// The angle of a vector in degrees in [0, 360), with an error below 0.01 degrees; 0 for the zero vector.
/// The same on all processors.
float angleOf(float x, float y);

}  // namespace corrsel::core
