#include "features/detectors/detector.h"

#include <cmath>
#include <tuple>
#include <utility>

namespace corrsel::core {

void DetectorOptions::visitCap(OptionVisitor& visitor) const {
  visitor.integer({"max_features", 0, 100000, "-", "Strongest features kept; 0 = no cap"},
                  &DetectorOptions::max_features);
  visitor.flag("spread", "With max_features: keep the strongest of every part of the image",
               &DetectorOptions::spread);
  visitor.number({"max_megapixels", 0.01, 1000, "10^6 px", "Larger images are reduced to this size first"},
                 &DetectorOptions::max_megapixels);
}

void Detector::detectWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                           Features& features) const {
  detect(grey, threads, features);
  dropRefused(allowed, features);
}

void SelfDescribingDetector::detectAndDescribeWhere(const cv::Mat& grey, int threads,
                                                    const PlaceFilter& allowed, Features& features) const {
  detectAndDescribe(grey, threads, features);
  dropRefused(allowed, features);
}

bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::make_tuple(-a.response, a.pt.y, a.pt.x, a.size, a.angle, a.octave, a.class_id) <
         std::make_tuple(-b.response, b.pt.y, b.pt.x, b.size, b.angle, b.octave, b.class_id);
}

void reorder(const std::vector<int>& order, Features& features) {
  std::vector<cv::KeyPoint> keypoints;
  std::vector<AffineFrame> frames;
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

void dropRefused(const PlaceFilter& allowed, Features& features) {
  std::vector<int> order;
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    if (allowed(features.keypoints[i].pt)) order.push_back(static_cast<int>(i));
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
