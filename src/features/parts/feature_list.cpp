#include "features/parts/feature_list.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <tuple>
#include <utility>

#include "features/parts/spread.h"

namespace corrsel::core {

bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::make_tuple(-a.response, a.pt.y, a.pt.x, a.size, a.angle, a.octave, a.class_id) <
         std::make_tuple(-b.response, b.pt.y, b.pt.x, b.size, b.angle, b.octave, b.class_id);
}

void reorder(const std::vector<int>& order, Features& features) {
  bool same = order.size() == features.keypoints.size();
  for (std::size_t i = 0; same && i < order.size(); ++i) same = order[i] == static_cast<int>(i);
  if (same) return;
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
  const std::size_t bytes = static_cast<std::size_t>(descriptors.cols) * descriptors.elemSize();
  int row = 0;
  for (const int i : order) std::memcpy(descriptors.ptr(row++), features.descriptors.ptr(i), bytes);
  features.descriptors = descriptors;
}

void keepFeatures(const std::vector<char>& keep, Features& features) {
  std::vector<int> order;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) order.push_back(static_cast<int>(i));
  }
  if (order.size() < keep.size()) reorder(order, features);
}

void keepStrongest(int max_features, bool spread, const cv::Size& image_size, Features& features) {
  const std::vector<cv::KeyPoint>& keypoints = features.keypoints;
  std::vector<int> order(keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto by_strength = [&keypoints](int a, int b) {
    const cv::KeyPoint &first = keypoints[static_cast<std::size_t>(a)],
                       &second = keypoints[static_cast<std::size_t>(b)];
    if (first.response != second.response) return first.response > second.response;
    if (stronger(first, second)) return true;
    return !stronger(second, first) && a < b;
  };
  const auto wanted = static_cast<std::ptrdiff_t>(max_features);
  const bool sorted = std::is_sorted(order.begin(), order.end(), by_strength);
  if (wanted > 0 && wanted < static_cast<std::ptrdiff_t>(order.size()) && !spread) {
    if (!sorted) std::nth_element(order.begin(), order.begin() + wanted, order.end(), by_strength);
    order.resize(static_cast<std::size_t>(max_features));
  }
  if (!sorted) std::sort(order.begin(), order.end(), by_strength);
  if (wanted > 0 && wanted < static_cast<std::ptrdiff_t>(order.size())) {
    std::vector<cv::Point2f> points;
    points.reserve(order.size());
    for (const int i : order) points.push_back(keypoints[static_cast<std::size_t>(i)].pt);
    std::vector<int> kept;
    kept.reserve(static_cast<std::size_t>(max_features));
    for (const std::size_t rank :
         spreadOverImage(points, image_size, static_cast<std::size_t>(max_features))) {
      kept.push_back(order[rank]);
    }
    order = std::move(kept);
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
