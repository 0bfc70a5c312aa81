#include "features/descriptors/orb.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/parallel.h"
#include "features/parts/feature_list.h"
#include "features/parts/image_pyramid.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kRows = 32;     // that a thread blurs at once
constexpr std::size_t kPatches = 64;  // that a thread describes at once

struct DescriptorMemory {
  ImagePyramid pyramid;
};

/// Where a keypoint is described.
struct Place {
  int level, x, y;
};

}  // namespace

OrbDescriptor::OrbDescriptor(const OrbOptions& options) : options_(options), patch_(options.patch_size) {
  options_.check();
}

void OrbDescriptor::describe(const cv::Mat& grey, int threads, Workspace& workspace,
                             Features& features) const {
  const int border = patch_.radius() + ImagePyramid::kBlurReach;
  std::vector<char> keep(features.keypoints.size(), 0);
  if (grey.cols <= 2 * options_.patch_size || grey.rows <= 2 * options_.patch_size) {
    keepFeatures(keep, features);
    return;
  }
  const int levels = usableLevels(grey.size(), options_.scale_factor, options_.levels, options_.patch_size);
  ImagePyramid& pyramid = workspace.part<DescriptorMemory>().pyramid;
  pyramid.start(grey, options_.scale_factor, levels, true);
  for (int level = 1; level < levels; ++level) pyramid.reduce(level, workspace);

  std::vector<Place> places;
  std::vector<char> used(static_cast<std::size_t>(levels), 0);
  for (std::size_t i = 0; i < keep.size(); ++i) {
    const cv::KeyPoint& keypoint = features.keypoints[i];
    const double fitting = std::log(keypoint.size / kFastDiameter) / std::log(options_.scale_factor);
    const auto number = static_cast<int>(std::clamp(std::round(fitting), 0.0, levels - 1.0));
    const PyramidLevel& level = pyramid.level(number);
    const cv::Point at = level.fromImage(keypoint.pt);
    if (!cv::Rect(border, border, level.width - 2 * border, level.height - 2 * border).contains(at)) continue;
    keep[i] = 1;
    used[static_cast<std::size_t>(number)] = 1;
    places.push_back({number, at.x, at.y});
  }
  keepFeatures(keep, features);
  for (int number = 0; number < levels; ++number) {
    if (!used[static_cast<std::size_t>(number)]) continue;
    const int first = ImagePyramid::kBlurReach, last = pyramid.level(number).height - first;
    forEachBlock(static_cast<std::size_t>(last - first), kRows, threads,
                 [&](std::size_t begin, std::size_t end) {
                   pyramid.blur(number,
                                {first, first + static_cast<int>(begin),
                                 pyramid.level(number).width - 2 * first, static_cast<int>(end - begin)},
                                Workspace::ofThread());
                 });
  }
  features.descriptors.create(static_cast<int>(places.size()), OrientedPatch::kBytes, CV_8U);
  forEachBlock(places.size(), kPatches, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Place& place = places[i];
      patch_.describe(pyramid.blurred(place.level), place.x, place.y, features.keypoints[i].angle,
                      features.descriptors.ptr(static_cast<int>(i)));
    }
  });
}

}  // namespace corrsel::core
