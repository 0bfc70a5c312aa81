#include "corrsel/features/orb.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace corrsel::core {

void OrbOptions::visit(OptionVisitor& visitor) {
  visitCap(visitor);
  visitor.number({"scale_factor", 1.05, 3, "-", "ORB: scale between pyramid levels"}, scale_factor);
  visitor.integer({"levels", 1, 16, "-", "ORB: levels of the pyramid"}, levels);
  visitor.integer({"fast_threshold", 0, 255, "grey levels", "ORB: smallest corner contrast"}, fast_threshold);
  visitor.integer({"patch_size", 5, 127, "px",
                   "ORB: side of the described patch; features nearer to the border are lost"},
                  patch_size);
}

namespace {

/// Diameter of the circle of pixels that FAST looks at.
constexpr double kFastDiameter = 7;
/// OpenCV's ORB has no "no cap" and hands its number out over the levels.
constexpr int kNoCap = 1000000;

/// Levels on which a patch still fits: OpenCV fails on a pyramid that shrinks to nothing.
int usableLevels(const OrbOptions& options, const cv::Size& size) {
  const double smallest = options.patch_size + 1.0;
  int levels = 1;
  for (double side = std::min(size.width, size.height) / options.scale_factor;
       levels < options.levels && side > smallest; side /= options.scale_factor) {
    ++levels;
  }
  return levels;
}

bool capsLevels(const OrbOptions& options) { return options.max_features > 0 && !options.spread; }

/// The strongest of every level, as many as OpenCV's ORB keeps of it.
void capLevels(const OrbOptions& options, const cv::Size& size, Features& features) {
  if (!capsLevels(options)) return;
  const int levels = usableLevels(options, size);
  const double factor = 1 / options.scale_factor;
  double share = options.max_features * (1 - factor) / (1 - std::pow(factor, levels));
  std::vector<std::vector<int>> by_level(static_cast<std::size_t>(levels));
  for (std::size_t i = 0; i < features.keypoints.size(); ++i) {
    by_level[static_cast<std::size_t>(features.keypoints[i].octave)].push_back(static_cast<int>(i));
  }
  int left = options.max_features;
  std::vector<int> kept;
  for (int level = 0; level < levels; ++level, share *= factor) {
    std::vector<int>& order = by_level[static_cast<std::size_t>(level)];
    std::sort(order.begin(), order.end(), [&features](int a, int b) {
      return stronger(features.keypoints[static_cast<std::size_t>(a)],
                      features.keypoints[static_cast<std::size_t>(b)]);
    });
    const int most = std::clamp(level + 1 < levels ? cvRound(share) : left, 0, left);
    left -= most;
    order.resize(std::min(order.size(), static_cast<std::size_t>(most)));
    kept.insert(kept.end(), order.begin(), order.end());
  }
  reorder(kept, features);
}

OpenCvDetector::Create create(const OrbOptions& options) {
  return [options](const cv::Size& size, bool capped) {
    return cv::ORB::create(capped && capsLevels(options) ? options.max_features : kNoCap,
                           static_cast<float>(options.scale_factor), usableLevels(options, size),
                           options.patch_size, 0, 2, cv::ORB::HARRIS_SCORE, options.patch_size,
                           options.fast_threshold);
  };
}

}  // namespace

OrbDetector::OrbDetector(const OrbOptions& options)
    : OpenCvDetector("orb", create(options), options.patch_size, kFastDiameter / options.patch_size),
      options_(options) {
  options_.check();
}

void OrbDetector::detectWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                              Features& features) const {
  OpenCvDetector::detectWhere(grey, threads, allowed, features);
  capLevels(options_, grey.size(), features);
}

void OrbDetector::detectAndDescribeWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                                         Features& features) const {
  OpenCvDetector::detectAndDescribeWhere(grey, threads, allowed, features);
  capLevels(options_, grey.size(), features);
}

OrbDescriptor::OrbDescriptor(const OrbOptions& options)
    : OpenCvDescriptor(
          "orb", create(options), options.patch_size,
          [options](const cv::Size& size, cv::KeyPoint& keypoint) {
            const double level = std::log(keypoint.size / kFastDiameter) / std::log(options.scale_factor);
            keypoint.octave =
                static_cast<int>(std::clamp(std::round(level), 0.0, usableLevels(options, size) - 1.0));
          }),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
