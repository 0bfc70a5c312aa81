#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace corrsel::core {

/// Ranges: those of AsiftOptions.
struct FastSiftParameters {
  int octave_layers = 3;  ///< layers per octave
  double contrast_threshold =
      0.04;                    ///< of grey levels / 255; divided by octave_layers inside, as in OpenCV's
  double edge_threshold = 10;  ///< largest ratio of the principal curvatures
  double sigma = 1.6;          ///< blur of the first level, px
  bool describe = true;        ///< else the descriptors are all zero
};

struct FastSiftFeature {
  float x, y;      ///< px
  float sigma;     ///< scale, px
  float angle;     ///< of the strongest gradients, radians in [0, 2 pi), clockwise in the image
  float response;  ///< contrast, grey levels / 255
  int octave;      ///< 0: that of the image itself
  std::array<std::uint8_t, 128> descriptor;  ///< length 512 before clipping to 255
};

/// A keypoint is described, and returned, where this says so.
using AcceptKeypoint = std::function<bool(float x, float y, float sigma)>;

/// SIFT (Lowe, IJCV 2004) of one picture in one thread, for callers that need many pictures: it starts from
/// the picture itself where OpenCV doubles it first (a quarter of the pixels; features below sigma * 1.2 px
/// are lost), computes gradients only around keypoints and leaves out the corners of the described square.
/// @param image  CV_32F, 0..255; sides below 16 px give no features
/// O(pixels) time, 12 float values of memory per pixel.
std::vector<FastSiftFeature> fastSift(const cv::Mat& image, const FastSiftParameters& parameters,
                                      const AcceptKeypoint& accept);

}  // namespace corrsel::core
