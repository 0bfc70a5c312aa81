#include "features/descriptors/freak.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <vector>

#include "base/parallel.h"
#include "features/descriptors/freak_pattern.h"
#include "features/parts/feature_list.h"

namespace corrsel::core {

void FreakOptions::visit(OptionVisitor& visitor) const {
  visitor.number({"pattern_scale", 5, 100, "px",
                  "FREAK: scale of the pattern around a keypoint of 7 px; its radius is as long"},
                 &FreakOptions::pattern_scale);
  visitor.flag("orientation_normalized", "FREAK: turn the pattern with the image; otherwise it stays upright",
               &FreakOptions::orientation_normalized);
  visitor.flag("scale_normalized", "FREAK: let the pattern grow with the keypoint",
               &FreakOptions::scale_normalized);
}

namespace {

constexpr float kDegrees = static_cast<float>(180 / CV_PI);

bool isSimilarity(const AffineFrame& frame) {
  const float tolerance = 1e-4F * (std::abs(frame[0]) + std::abs(frame[1]));
  return std::abs(frame[0] - frame[4]) <= tolerance && std::abs(frame[1] + frame[3]) <= tolerance;
}

}  // namespace

FreakDescriptor::FreakDescriptor(const FreakOptions& options) : options_(options) { options_.check(); }

void FreakDescriptor::describe(const cv::Mat& grey, int threads, Workspace&, Features& features) const {
  const FreakSampler sampler(grey, options_.pattern_scale);
  const auto sizeOf = [this](const cv::KeyPoint& keypoint) {
    return options_.scale_normalized ? static_cast<double>(keypoint.size) : kFreakUnitSize;
  };
  std::vector<char> fits;
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    fits.push_back(sampler.fits(keypoint.pt, sizeOf(keypoint)) ? 1 : 0);
  }
  keepFeatures(fits, features);
  const int count = static_cast<int>(features.keypoints.size());
  features.descriptors = cv::Mat::zeros(count, static_cast<int>(kFreakTests / 8), CV_8U);

  forEachBlock(features.keypoints.size(), 64, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      cv::KeyPoint& keypoint = features.keypoints[i];
      const double size = sizeOf(keypoint);
      double angle = 0;
      if (options_.orientation_normalized) {
        angle = sampler.orientation(keypoint.pt, size);
        const float degrees = static_cast<float>(angle) * kDegrees;
        keypoint.angle = degrees < 0 ? degrees + 360 : degrees;
      }
      const FreakSampler::Means means = sampler.means(keypoint.pt, size, angle);
      auto* const bits = features.descriptors.ptr<std::uint8_t>(static_cast<int>(i));
      for (std::size_t test = 0; test < kFreakTests; ++test) {
        const auto [a, b] = kFreakPairs[test];
        bits[test / 8] = static_cast<std::uint8_t>(bits[test / 8] | ((means[a] > means[b]) << (test % 8)));
      }
    }
  });

  if (!options_.orientation_normalized) return;
  const std::vector<AffineFrame> turned = similarityFrames(features.keypoints);
  for (std::size_t i = 0; i < turned.size(); ++i) {
    if (isSimilarity(features.frames[i])) features.frames[i] = turned[i];
  }
}

}  // namespace corrsel::core
