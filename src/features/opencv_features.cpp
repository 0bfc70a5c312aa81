#include "corrsel/features/opencv_features.h"

#include <utility>

namespace corrsel::core {

OpenCvDetector::OpenCvDetector(std::string name, Create create, int border, double size_factor)
    : name_(std::move(name)), create_(std::move(create)), border_(border), size_factor_(size_factor) {}

void OpenCvDetector::run(const cv::Mat& grey, bool capped, bool describe, Features& features) const {
  if (grey.cols <= 2 * border_ || grey.rows <= 2 * border_) return;
  const cv::Ptr<cv::Feature2D> algorithm = create_(grey.size(), capped);
  if (describe) {
    algorithm->detectAndCompute(grey, cv::noArray(), features.keypoints, features.descriptors);
  } else {
    algorithm->detect(grey, features.keypoints);
    for (cv::KeyPoint& keypoint : features.keypoints) {
      keypoint.size = static_cast<float>(keypoint.size * size_factor_);
    }
  }
  features.frames = similarityFrames(features.keypoints);
}

void OpenCvDetector::detect(const cv::Mat& grey, int, Features& features) const {
  run(grey, true, false, features);
}

void OpenCvDetector::detectAndDescribe(const cv::Mat& grey, int, Features& features) const {
  run(grey, true, true, features);
}

// OpenCV's masks will not do: SIFT applies them after its cap, and ORB lets their holes grow on each level.
void OpenCvDetector::detectWhere(const cv::Mat& grey, int, const PlaceFilter& allowed,
                                 Features& features) const {
  run(grey, false, false, features);
  dropRefused(allowed, features);
}

void OpenCvDetector::detectAndDescribeWhere(const cv::Mat& grey, int, const PlaceFilter& allowed,
                                            Features& features) const {
  run(grey, false, true, features);
  dropRefused(allowed, features);
}

OpenCvDescriptor::OpenCvDescriptor(std::string name, OpenCvDetector::Create create, int border,
                                   Prepare prepare)
    : name_(std::move(name)), create_(std::move(create)), border_(border), prepare_(std::move(prepare)) {}

void OpenCvDescriptor::describe(const cv::Mat& grey, int, Features& features) const {
  if (grey.cols <= 2 * border_ || grey.rows <= 2 * border_) {
    keepFeatures(std::vector<char>(features.keypoints.size(), 0), features);
  }
  if (features.keypoints.empty()) return;
  // OpenCV drops keypoints near the border and regroups the others: class_id tells which is which.
  std::vector<cv::KeyPoint> keypoints = features.keypoints;
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    keypoints[i].class_id = static_cast<int>(i);
    prepare_(grey.size(), keypoints[i]);
  }
  cv::Mat descriptors;
  create_(grey.size(), false)->compute(grey, keypoints, descriptors);
  std::vector<char> keep(features.keypoints.size(), 0);
  std::vector<int> row_of(keep.size());
  for (std::size_t row = 0; row < keypoints.size(); ++row) {
    const auto i = static_cast<std::size_t>(keypoints[row].class_id);
    keep[i] = 1;
    row_of[i] = static_cast<int>(row);
  }
  features.descriptors.create(static_cast<int>(keypoints.size()), descriptors.cols, descriptors.type());
  int kept = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) descriptors.row(row_of[i]).copyTo(features.descriptors.row(kept++));
  }
  keepFeatures(keep, features);
}

}  // namespace corrsel::core
