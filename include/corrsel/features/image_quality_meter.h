#pragma once

#include <cstdint>
#include <deque>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "corrsel/features/features.h"
#include "corrsel/features/image_quality.h"

namespace corrsel::core {

/// Measures what the images of one camera suffer from.
///
/// Black and saturated: the shares of the pixels up to 7 and of those at 255, of 8 bits. All pixels are
/// counted in images of up to 640 x 480 px, else those of every k-th row.
///
/// Noise: the operator of Immerkaer ("Fast noise variance estimation", 1996), which leaves out constant and
/// linear parts of an image, on cells of 16 x 16 px; the estimate is that of the calmest cells. Fixed
/// patterns of a Bayer filter and JPEG change it.
///
/// Blur: along lines in both directions, the grey value rises or falls from one extremum to the next. A step
/// of height a that is blurred by a Gaussian has the energy of differences a^2 / (2 sqrt(pi) sigma), which
/// gives sigma whatever the contrast. Energy of the noise, the widening by pixels and by smoothing, and the
/// angle between line and edge are taken into account. The blur of a direction is a low quantile over its
/// edges, because scenes have soft edges, too; that of the image is the larger one of both directions,
/// because motion blurs in one. Below 0.4 px the grid of the pixels hides the difference.
///
/// Cost: a fixed number of samples, at most 0.1 ms for 640 x 480 px and 0.2 ms for larger images of 8-bit
/// grey; colours and 16 bits are converted first, in the samples only.
///
/// Not thread-safe.
class ImageQualityMeter {
 public:
  /// Measures an image of the camera. Throws std::invalid_argument for an image that is empty or of a type
  /// that FeatureExtractor::extract() refuses. `texture` stays undefined: see textureOf(). Images below 32 px
  /// have no blur and no noise.
  /// @param stamp  s; a stamp before the last one forgets the images before
  ImageQuality measure(const cv::Mat& image, double stamp);

 private:
  /// The smallest blur within a short time.
  struct Moment {
    double stamp, blur;
  };

  double relativeBlur(double blur, double stamp);

  std::deque<Moment> moments_;      ///< of the last seconds, newest last, at most some 20
  std::vector<std::uint8_t> grey_;  ///< memory of the samples of images that are not 8-bit grey
};

/// The share of the cells of a grid of 8 x 8 over the image that have features; NaN for an image without a
/// size. O(features).
double textureOf(const Features& features);

}  // namespace corrsel::core
