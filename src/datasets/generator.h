#pragma once

#include <cstdint>
#include <opencv2/core/base.hpp>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <string>

#include "corrsel/random.h"

namespace corrsel::core {

/// The remedy in errors about the photographs of the sample set.
inline constexpr const char* kSampleRemedy = "fetch the sample photographs with fetch_samples.sh";

/// The random engine of a generated pair. Its seed is a hash of seed, sequence and strength (0-based).
Random engineOf(std::int64_t seed, const std::string& sequence, int strength);

// The pictures are the same on every machine: the functions below use whole numbers and exactly rounded
// operations, and whatever comes from the mathematics library, which differs in its last bits, is rounded.

/// Rounds the elements to 40 significant bits.
cv::Matx33d rounded(const cv::Matx33d& homography);

/// Turns `map`, given in px about the image centre, into a homography between pixel coordinates, rounded().
cv::Matx33d aboutCentre(const cv::Matx33d& map, const cv::Size& size);

/// Rotates by `degrees` (from x to y) and shrinks by the factor `scale` about the image centre.
cv::Matx33d similarity(double scale, double degrees, const cv::Size& size);

/// Convolves with a Gaussian of standard deviation `sigma` (px), cut off at three of them, whose weights are
/// multiples of 1/256.
/// @param image  8 bit
cv::Mat blur(const cv::Mat& image, double sigma, cv::BorderTypes border);

/// Smooths where the map shrinks, as the lens and the area of a pixel do, so that a distant view is blurred
/// and not aliased.
/// @param image  8 bit; returned itself where the map does not shrink
cv::Mat antialiased(const cv::Mat& image, const cv::Matx33d& homography);

/// Warps onto a canvas of the same size, black where the image does not reach, and interpolates linearly on a
/// grid of 1/32 px.
/// @param image  8 bit
cv::Mat warp(const cv::Mat& image, const cv::Matx33d& homography);

/// Adds a sensor's noise: Gaussian, 2 grey levels.
/// @param image  8 bit, changed in place
void addNoise(cv::Mat& image, Random& random);

}  // namespace corrsel::core
