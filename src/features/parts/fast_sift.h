#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace corrsel::core {

/// The ranges are those of AsiftOptions.
struct FastSiftParameters {
  int octave_layers = 3;  ///< layers per octave
  /// Smallest contrast, grey levels / 255; it is divided by octave_layers, as in OpenCV's SIFT.
  double contrast_threshold = 0.04;
  double edge_threshold = 10;  ///< largest ratio of the principal curvatures
  double sigma = 1.6;          ///< blur of the first level, px
  bool describe = true;        ///< otherwise the descriptors are all zero
};

struct FastSiftFeature {
  float x, y;      ///< px
  float sigma;     ///< scale, px
  float angle;     ///< direction of the strongest gradients, radians in [0, 2 pi), clockwise in the image
  float response;  ///< contrast, grey levels / 255
  int octave;      ///< 0 is the octave of the image itself
  std::array<std::uint8_t, 128> descriptor;  ///< length 512 before clipping to 255
};

/// Returns whether a keypoint is described and returned. Position and scale are in px.
using AcceptKeypoint = std::function<bool(float x, float y, float sigma)>;

/// SIFT of one image in one thread, for callers that need SIFT of many images.
///
/// Idea: What OpenCV's SIFT does for precision in one image is too slow for the 42 views of ASIFT.
///
/// Algorithm: As OpenCV's, except that it starts from the image itself instead of the doubled image (a
/// quarter of the pixels; features below a scale of sigma * 1.2 px are lost), computes gradients only around
/// keypoints, and leaves out the corners of the described square.
///
/// Input: CV_32F, grey levels from 0 to 255.
///
/// Failure: Images whose width or height is below 16 px have no features.
///
/// Cost: O(pixels) time and 12 floats per pixel.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004.
///
/// @param accept  is called before the orientations of a keypoint are computed
std::vector<FastSiftFeature> fastSift(const cv::Mat& image, const FastSiftParameters& parameters,
                                      const AcceptKeypoint& accept);

}  // namespace corrsel::core
