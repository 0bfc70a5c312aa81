#include "corrsel/database/two_view_geometry.h"

#include <opencv2/core.hpp>  // inv()

namespace corrsel::core {

std::string toString(TwoViewConfig config) {
  switch (config) {
    case TwoViewConfig::kUndefined:
      return "undefined";
    case TwoViewConfig::kDegenerate:
      return "degenerate";
    case TwoViewConfig::kCalibrated:
      return "calibrated";
    case TwoViewConfig::kUncalibrated:
      return "uncalibrated";
    case TwoViewConfig::kPlanar:
      return "planar";
    case TwoViewConfig::kPanoramic:
      return "panoramic";
    case TwoViewConfig::kPlanarOrPanoramic:
      return "planar_or_panoramic";
    case TwoViewConfig::kWatermark:
      return "watermark";
    case TwoViewConfig::kMultiple:
      return "multiple";
  }
  return "undefined";
}

TwoViewGeometry exchanged(const TwoViewGeometry& geometry) {
  TwoViewGeometry result = geometry;
  for (KeypointPair& row : result.inliers) row = {row[1], row[0]};
  if (result.fundamental) result.fundamental = result.fundamental->t();
  if (result.essential) result.essential = result.essential->t();
  if (result.homography) result.homography = result.homography->inv();
  if (result.pose) {
    const cv::Matx33d inverse = geometry.pose->rotation.t();
    result.pose->rotation = inverse;
    result.pose->translation = -(inverse * geometry.pose->translation);
  }
  return result;
}

}  // namespace corrsel::core
