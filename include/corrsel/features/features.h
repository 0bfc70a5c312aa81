#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/correspondences.h"

namespace corrsel::core {

/// Features of one image: keypoints and one descriptor row each.
struct Features {
  std::vector<cv::KeyPoint>
      keypoints;                    ///< position px, size = diameter px, angle degrees (OpenCV's conventions)
  std::vector<AffineFrame> frames;  ///< affine frame of every keypoint, px
  cv::Mat descriptors;              ///< N x D; CV_32F is compared by L2, CV_8U by Hamming distance
  cv::Size image_size;              ///< px
  double detect_seconds = 0.0;      ///< includes the description where one pass detects and describes
  double describe_seconds = 0.0;    ///< 0 where one pass detects and describes
};

}  // namespace corrsel::core
