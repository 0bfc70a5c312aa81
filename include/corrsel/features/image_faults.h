#pragma once

#include <limits>
#include <opencv2/core/matx.hpp>
#include <string>

#include "corrsel/features/image_quality.h"

namespace corrsel::core {

/// What an image suffers from, in words and with numbers: "the left image is dark: 93 % of the pixels are
/// black". Empty where nothing is known to be wrong. Numbers that were not measured name no fault. The limits
/// are measured: see docs/studies/image_quality.md.
/// @param name       of the image: "left image", "image"
/// @param turn_rate  of the camera, rad/s, which explains blur; NaN = not known
std::string faultsOf(const ImageQuality& quality, const std::string& name,
                     double turn_rate = std::numeric_limits<double>::quiet_NaN());

/// Why a pair of images has few matches, as far as the images themselves explain it: faultsOf() of both.
std::string faultsOf(const ImageQuality& left, const ImageQuality& right, double turn_rate);

/// The numbers of an image: "black 2 %, saturated 10 %, blur 0.5 px (1.0 times that of sharp images),
/// noise 1.6 of 255, features in 53 of 64 cells". What was not measured is left out.
std::string toText(const ImageQuality& quality);

/// How fast a camera turns, rad/s; NaN where the time is 0.
/// @param rotation  between two images
/// @param seconds   between them; the sign does not count
double turnRate(const cv::Matx33d& rotation, double seconds);

}  // namespace corrsel::core
