#include "features/detectors/opencv_detector.h"

#include <algorithm>
#include <utility>

#include "features/parts/feature_list.h"
#include "features/parts/grey_image.h"

namespace corrsel::core {
namespace {

/// The share of the image where keypoints are allowed, estimated from samples.
double allowedShare(const cv::Size& size, const PlaceMask& mask) {
  constexpr int kSamples = 32;
  int inside = 0;
  for (int y = 0; y < kSamples; ++y) {
    for (int x = 0; x < kSamples; ++x) {
      inside +=
          mask.allows({(static_cast<float>(x) + 0.5F) * static_cast<float>(size.width) / kSamples - 0.5F,
                       (static_cast<float>(y) + 0.5F) * static_cast<float>(size.height) / kSamples - 0.5F});
    }
  }
  return static_cast<double>(inside) / (kSamples * kSamples);
}

/// How many features to request so that probably `wanted` remain where the given share of them is allowed;
/// 0 = all.
int requestedNumber(int wanted, double share) {
  constexpr double kReserve = 1.5, kAll = 1e6;
  const double number = kReserve * wanted / share;
  return number < kAll ? static_cast<int>(number) : 0;
}

}  // namespace

OpenCvDetector::OpenCvDetector(std::string name, CreateOpenCv create, int border, double size_factor)
    : name_(std::move(name)), create_(std::move(create)), border_(border), size_factor_(size_factor) {}

std::vector<int> OpenCvDetector::shares(const cv::Size&, int) const { return {}; }

int OpenCvDetector::limit() const { return options().spread ? 0 : options().max_features; }

void OpenCvDetector::run(const DetectionRequest& request, int max_features, Features& features) const {
  const cv::Mat grey = detached(request.image);
  if (grey.cols <= 2 * border_ || grey.rows <= 2 * border_) return;
  const cv::Ptr<cv::Feature2D> algorithm = create_(grey.size(), max_features);
  if (request.describe) {
    algorithm->detectAndCompute(grey, cv::noArray(), features.keypoints, features.descriptors);
  } else {
    algorithm->detect(grey, features.keypoints);
    for (cv::KeyPoint& keypoint : features.keypoints) {
      keypoint.size = static_cast<float>(keypoint.size * size_factor_);
    }
  }
  features.frames = similarityFrames(features.keypoints);
}

void OpenCvDetector::detect(const DetectionRequest& request, Features& features) const {
  if (request.mask.everywhere()) {
    run(request, limit(), features);
  } else {
    runMasked(request, features);
  }
}

void OpenCvDetector::runMasked(const DetectionRequest& request, Features& features) const {
  const cv::Size size = request.image.size();
  const std::vector<int> wanted = shares(size, limit());
  if (limit() == 0 || wanted.empty()) {
    run(request, 0, features);
    request.mask.apply(features);
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
  int max_features = requestedNumber(limit(), allowedShare(size, request.mask));
  for (int attempt = 0;; ++attempt) {
    run(request, max_features, features);
    const std::vector<std::vector<int>> found = byShare();
    request.mask.apply(features);
    kept = byShare();
    const std::vector<int> allowed = shares(size, max_features);
    double min_share = 1;  // of what was wanted of an octave that may have more
    for (std::size_t i = 0; i < wanted.size(); ++i) {
      const auto kept_here = static_cast<int>(kept[i].size()), found_here = static_cast<int>(found[i].size());
      if (kept_here >= wanted[i] || found_here < allowed[i]) continue;
      min_share = std::min(min_share, static_cast<double>(kept_here) / wanted[i]);
    }
    if (max_features == 0 || min_share >= 1) break;
    max_features = attempt == 0 ? requestedNumber(max_features, min_share) : 0;
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

}  // namespace corrsel::core
