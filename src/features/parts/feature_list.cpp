#include "features/parts/feature_list.h"

#include <cmath>
#include <tuple>
#include <utility>

namespace corrsel::core {

bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::make_tuple(-a.response, a.pt.y, a.pt.x, a.size, a.angle, a.octave, a.class_id) <
         std::make_tuple(-b.response, b.pt.y, b.pt.x, b.size, b.angle, b.octave, b.class_id);
}

void reorder(const std::vector<int>& order, Features& features) {
  std::vector<cv::KeyPoint> keypoints;
  std::vector<AffineFrame> frames;
  keypoints.reserve(order.size());
  frames.reserve(order.size());
  for (const int i : order) {
    keypoints.push_back(features.keypoints[static_cast<std::size_t>(i)]);
    frames.push_back(features.frames[static_cast<std::size_t>(i)]);
  }
  features.keypoints = std::move(keypoints);
  features.frames = std::move(frames);
  if (features.descriptors.empty()) return;
  cv::Mat descriptors(static_cast<int>(order.size()), features.descriptors.cols, features.descriptors.type());
  int row = 0;
  for (const int i : order) features.descriptors.row(i).copyTo(descriptors.row(row++));
  features.descriptors = descriptors;
}

void keepFeatures(const std::vector<char>& keep, Features& features) {
  std::vector<int> order;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) order.push_back(static_cast<int>(i));
  }
  reorder(order, features);
}

std::vector<AffineFrame> similarityFrames(const std::vector<cv::KeyPoint>& keypoints) {
  std::vector<AffineFrame> frames;
  frames.reserve(keypoints.size());
  for (const cv::KeyPoint& keypoint : keypoints) {
    const double angle = keypoint.angle * CV_PI / 180, radius = keypoint.size / 2.0;
    const auto c = static_cast<float>(radius * std::cos(angle));
    const auto s = static_cast<float>(radius * std::sin(angle));
    frames.push_back({c, -s, keypoint.pt.x, s, c, keypoint.pt.y});
  }
  return frames;
}

}  // namespace corrsel::core
