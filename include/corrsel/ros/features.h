#pragma once

#include <std_msgs/Header.h>

#include <limits>
#include <optional>
#include <string>

#include "corrsel/Features.h"
#include "corrsel/camera.h"
#include "corrsel/features/features.h"

namespace corrsel {

/// Everything in a Features message beside the features.
struct FeatureInfo {
  std_msgs::Header header;  ///< stamp and frame of the image
  std::string name;         ///< what has made the features, e.g. "superpoint"
  std::optional<core::Camera> camera;
  double seconds =
      std::numeric_limits<double>::quiet_NaN();  ///< wall time of making them, NaN = not measured
};

/// Converts features to a message. CV_8U descriptors are binary there, and CV_32F ones are numbers. The
/// response of a keypoint is its score, and its size and angle replace the frames. Throws
/// std::invalid_argument for descriptors of another type or number than that of the keypoints; there may be
/// none. O(features).
Features toMsg(const core::Features& features, const FeatureInfo& info);

/// Converts a message to features, as core::matchFeatures() takes them: binary descriptors are CV_8U, and
/// numbers of every type are CV_32F. Sizes and angles give the frames that cv::KeyPoint stands for, and
/// without either of them there are no frames. Times are 0.
/// @param info  filled with everything else in the message where it is not null
/// Throws std::invalid_argument that names the field, its value and what was expected if array lengths
/// disagree, the type of the descriptors is unknown, the number of their bytes is not that of as many rows as
/// there are keypoints, an image size is larger than any image can be, or the camera is none. O(bytes).
core::Features fromMsg(const Features& msg, FeatureInfo* info = nullptr);

}  // namespace corrsel
