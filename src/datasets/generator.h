#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <string>

#include "corrsel/random.h"

namespace corrsel::core {

/// The remedy in errors about the photographs of the sample set.
inline constexpr const char* kSampleRemedy = "fetch the sample photographs with fetch_samples.sh";

/// The random engine of a generated pair. Its seed is a hash of seed, sequence and strength (0-based).
Random engineOf(std::int64_t seed, const std::string& sequence, int strength);

/// Turns `map`, given in px about the image centre, into a homography between pixel coordinates.
cv::Matx33d aboutCentre(const cv::Matx33d& map, const cv::Size& size);

/// Rotates by `degrees` (from x to y) and shrinks by the factor `scale` about the image centre.
cv::Matx33d similarity(double scale, double degrees, const cv::Size& size);

/// Warps onto a canvas of the same size. Where the map shrinks, the image is smoothed first, as the lens and
/// the area of a pixel do, so that a distant view is blurred and not aliased.
cv::Mat warp(const cv::Mat& image, const cv::Matx33d& homography);

/// Adds a sensor's noise: Gaussian, 2 grey levels.
/// @param image  8 bit, changed in place
void addNoise(cv::Mat& image, Random& random);

}  // namespace corrsel::core
