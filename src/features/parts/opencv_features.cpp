#include "features/parts/opencv_features.h"

#include <algorithm>
#include <utility>

namespace corrsel::core {

namespace {

/// How much of the image is allowed, from samples.
double allowedPart(const cv::Size& size, const PlaceFilter& allowed) {
  constexpr int kSamples = 32;
  int inside = 0;
  for (int y = 0; y < kSamples; ++y) {
    for (int x = 0; x < kSamples; ++x) {
      inside += allowed({(static_cast<float>(x) + 0.5F) * static_cast<float>(size.width) / kSamples - 0.5F,
                         (static_cast<float>(y) + 0.5F) * static_cast<float>(size.height) / kSamples - 0.5F});
    }
  }
  return static_cast<double>(inside) / (kSamples * kSamples);
}

/// How many features to ask for so that `wanted` remain, probably, where a part of them does; 0 = all.
int asked(int wanted, double part) {
  constexpr double kReserve = 1.5, kAll = 1e6;
  const double number = kReserve * wanted / part;
  return number < kAll ? static_cast<int>(number) : 0;
}

}  // namespace

OpenCvDetector::OpenCvDetector(std::string name, Create create, int border, double size_factor)
    : name_(std::move(name)), create_(std::move(create)), border_(border), size_factor_(size_factor) {}

std::vector<int> OpenCvDetector::shares(const cv::Size&, int) const { return {}; }

int OpenCvDetector::cap() const { return options().spread ? 0 : options().max_features; }

void OpenCvDetector::run(const cv::Mat& grey, int most, bool describe, Features& features) const {
  if (grey.cols <= 2 * border_ || grey.rows <= 2 * border_) return;
  const cv::Ptr<cv::Feature2D> algorithm = create_(grey.size(), most);
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
  run(grey, cap(), false, features);
}

void OpenCvDetector::detectAndDescribe(const cv::Mat& grey, int, Features& features) const {
  run(grey, cap(), true, features);
}

// OpenCV's masks will not do: SIFT applies them after its cap, and ORB lets their holes grow on each level.
// Instead it is asked for as many as should leave enough, and where they do not, for more.
void OpenCvDetector::runWhere(const cv::Mat& grey, bool describe, const PlaceFilter& allowed,
                              Features& features) const {
  const std::vector<int> wanted = shares(grey.size(), cap());
  if (cap() == 0 || wanted.empty()) {
    run(grey, 0, describe, features);
    dropRefused(allowed, features);
    return;
  }
  const auto byShare = [&] {
    std::vector<std::vector<int>> numbers(wanted.size());
    for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
      const int octave = wanted.size() == 1 ? 0 : features.keypoints[i].octave;
      numbers[static_cast<std::size_t>(octave)].push_back(static_cast<int>(i));
    }
    return numbers;
  };
  std::vector<std::vector<int>> kept;
  int most = asked(cap(), allowedPart(grey.size(), allowed));
  for (int attempt = 0;; ++attempt) {
    run(grey, most, describe, features);
    const std::vector<std::vector<int>> found = byShare();
    dropRefused(allowed, features);
    kept = byShare();
    const std::vector<int> limit = shares(grey.size(), most);
    double least = 1;  // of what was wanted of an octave that may have more
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const auto kept_here = static_cast<int>(kept[i].size()), found_here = static_cast<int>(found[i].size());
      if (kept_here >= wanted[i] || found_here < limit[i]) continue;
      least = std::min(least, static_cast<double>(kept_here) / wanted[i]);
    }
    if (most == 0 || least >= 1) break;
    most = attempt == 0 ? asked(most, least) : 0;
  }
  std::vector<int> order;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    std::sort(kept[i].begin(), kept[i].end(), [&features](int a, int b) {
      return stronger(features.keypoints[static_cast<std::size_t>(a)],
                      features.keypoints[static_cast<std::size_t>(b)]);
    });
    kept[i].resize(std::min(kept[i].size(), static_cast<std::size_t>(wanted[i])));
    order.insert(order.end(), kept[i].begin(), kept[i].end());
  }
  reorder(order, features);
}

void OpenCvDetector::detectWhere(const cv::Mat& grey, int, const PlaceFilter& allowed,
                                 Features& features) const {
  runWhere(grey, false, allowed, features);
}

void OpenCvDetector::detectAndDescribeWhere(const cv::Mat& grey, int, const PlaceFilter& allowed,
                                            Features& features) const {
  runWhere(grey, true, allowed, features);
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
  create_(grey.size(), 0)->compute(grey, keypoints, descriptors);
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
