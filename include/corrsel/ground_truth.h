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
  kDisparity = 4
};

std::string toString(TruthKind kind);

/// Ground truth of an image pair. Only the members of the given kind are meaningful. evaluation/errors.h
/// computes the errors of matches against it.
struct GroundTruth {
  TruthKind kind = TruthKind::kNone;
  cv::Matx33d matrix = cv::Matx33d::eye();  ///< homography (x' ~ Hx) or fundamental matrix (x'^T F x = 0), px
  std::vector<std::uint32_t> labels;        ///< per given match: 0 = outlier, k = member of structure k
  cv::Mat disparity;  ///< CV_32F, size of the left image: left x minus right x, px; NaN = unknown
  std::optional<RelativePose> pose;  ///< where the calibration of the pair is known, with any kind
};

}  // namespace corrsel::core
