#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace corrsel::core {

inline constexpr std::size_t kOrbTests = 256;
inline constexpr int kOrbRadius = 15;  ///< of the patch of 31 px in which the tests lie, px

/// A test compares the pixels at two places, relative to the keypoint, px of the level.
struct OrbTest {
  std::int8_t x1, y1, x2, y2;
};

/// The tests for a keypoint with the angle 0. scripts/maintenance/train_orb.sh generates them by the
/// procedure of section 4.3, which prefers tests whose results on the features of the sample images are
/// evenly distributed and little correlated.
///
/// Source: Rublee, Rabaud, Konolige and Bradski, "ORB: an efficient alternative to SIFT or SURF", ICCV 2011.
extern const std::array<OrbTest, kOrbTests> kOrbPattern;

}  // namespace corrsel::core
