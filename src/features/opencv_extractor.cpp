#include "corrsel/features/opencv_extractor.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "corrsel/stopwatch.h"

namespace corrsel::core {
namespace {

cv::Mat toGrey(const cv::Mat& image) {
  if (image.empty()) throw std::invalid_argument("image is empty");
  if (image.depth() != CV_8U || image.channels() == 2 || image.channels() > 4) {
    throw std::invalid_argument("image has type " + cv::typeToString(image.type()) +
                                "; needed: 8 bits with 1, 3 (BGR) or 4 (BGRA) channels");
  }
  if (image.channels() == 1) return image;
  cv::Mat grey;
  cv::cvtColor(image, grey, image.channels() == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  return grey;
}

/// Strongest first; ties are broken by position, scale and angle, so that threads inside OpenCV cannot
/// reorder them.
bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b) {
  return std::make_tuple(-a.response, a.pt.y, a.pt.x, a.size, a.angle, a.octave) <
         std::make_tuple(-b.response, b.pt.y, b.pt.x, b.size, b.angle, b.octave);
}

/// Some algorithms reorder what they are asked to describe: ORB by pyramid level.
void sortStrongestFirst(Features& features) {
  std::vector<int> order(features.keypoints.size());
  std::iota(order.begin(), order.end(), 0);
  const auto before = [&features](int a, int b) {
    return stronger(features.keypoints[static_cast<std::size_t>(a)],
                    features.keypoints[static_cast<std::size_t>(b)]);
  };
  if (std::is_sorted(order.begin(), order.end(), before)) return;
  std::stable_sort(order.begin(), order.end(), before);
  Features sorted;
  sorted.descriptors.create(features.descriptors.size(), features.descriptors.type());
  for (const int i : order) {
    features.descriptors.row(i).copyTo(sorted.descriptors.row(static_cast<int>(sorted.keypoints.size())));
    sorted.keypoints.push_back(features.keypoints[static_cast<std::size_t>(i)]);
  }
  features.keypoints = std::move(sorted.keypoints);
  features.descriptors = sorted.descriptors;
}

/// Similarity frames from scale and angle; none where the detector gives no angle.
std::vector<AffineFrame> framesOf(const std::vector<cv::KeyPoint>& keypoints) {
  std::vector<AffineFrame> frames;
  frames.reserve(keypoints.size());
  for (const cv::KeyPoint& keypoint : keypoints) {
    if (keypoint.angle < 0) return {};
    const double angle = keypoint.angle * CV_PI / 180, radius = keypoint.size / 2.0;
    const auto c = static_cast<float>(radius * std::cos(angle));
    const auto s = static_cast<float>(radius * std::sin(angle));
    frames.push_back({c, -s, keypoint.pt.x, s, c, keypoint.pt.y});
  }
  return frames;
}

}  // namespace

OpenCvExtractor::OpenCvExtractor(std::string name, Create create, int max_features, int border)
    : name_(std::move(name)), create_(std::move(create)), max_features_(max_features), border_(border) {}

Features OpenCvExtractor::extract(const cv::Mat& image) const {
  Features features;
  features.image_size = image.size();
  const cv::Mat grey = toGrey(image);
  if (grey.cols <= 2 * border_ || grey.rows <= 2 * border_) return features;
  const cv::Ptr<cv::Feature2D> algorithm = create_(grey.size());
  Stopwatch watch;
  algorithm->detect(grey, features.keypoints);
  std::sort(features.keypoints.begin(), features.keypoints.end(), stronger);
  if (max_features_ > 0 && features.keypoints.size() > static_cast<std::size_t>(max_features_)) {
    features.keypoints.resize(static_cast<std::size_t>(max_features_));
  }
  features.detect_seconds = watch.restart();
  if (!features.keypoints.empty()) {
    algorithm->compute(grey, features.keypoints, features.descriptors);
    sortStrongestFirst(features);
    features.frames = framesOf(features.keypoints);
  }
  features.describe_seconds = watch.seconds();
  return features;
}

}  // namespace corrsel::core
