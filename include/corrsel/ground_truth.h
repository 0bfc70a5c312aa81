#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/relative_pose.h"

namespace corrsel::core {

enum class TruthKind : std::uint8_t {
  kNone = 0,
  kHomography = 1,
  kFundamental = 2,
  kLabels = 3,
  kDisparity = 4,
  kEssential = 5,  ///< of cameras that are no pinholes without distortion: their images are not rectified
  kRotation = 6    ///< the same of a camera that only turned
};

std::string toString(TruthKind kind);

/// Throws std::invalid_argument listing the valid texts.
TruthKind truthKindFromString(const std::string& text);

/// Ground truth of an image pair. Only the members of the given kind are meaningful. evaluation/errors.h
/// computes the errors of matches against it.
struct GroundTruth {
  TruthKind kind = TruthKind::kNone;
  /// Homography (x' ~ H x) or fundamental matrix (x'^T F x = 0), px; essential matrix (d'^T E d = 0) or
  /// rotation (d' = R d) of the unit rays of the matches' cameras.
  cv::Matx33d matrix = cv::Matx33d::eye();
  std::vector<std::uint32_t> labels;  ///< per given match: 0 = outlier, k = member of structure k
  cv::Mat disparity;  ///< CV_32F, size of the left image: left x minus right x, px; NaN = unknown
  std::optional<RelativePose> pose;  ///< where the calibration of the pair is known, with any kind
};

}  // namespace corrsel::core
