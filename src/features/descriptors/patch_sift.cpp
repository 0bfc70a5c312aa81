#include "features/descriptors/patch_sift.h"

#include <cstdint>
#include <vector>

#include "features/parts/feature_list.h"
#include "features/parts/root_sift.h"
#include "features/parts/scale_space.h"
#include "features/parts/sift_descriptor.h"

namespace corrsel::core {
namespace {

/// Kept for the next image.
struct PatchSiftPyramid {
  ScaleSpace space;
  cv::Mat image;
};

/// Levels whose blurs are a factor of sqrt(2) apart, from the image itself on. The resolution is halved where
/// the blur allows it. None where the image is too small.
std::vector<ScaleLevel> levelsOf(const cv::Mat& grey, int threads, Workspace& workspace) {
  auto& [space, image] = workspace.part<PatchSiftPyramid>();
  grey.convertTo(image, CV_16S, kGreyUnit);
  ScaleSpaceOptions options;
  options.first_octave = 0;
  options.resolution = 2;
  options.last_level = 2;
  options.sigma = 1;
  options.min_side = 2;
  space.compute(image, options, threads);
  std::vector<ScaleLevel> levels;
  for (const ScaleOctave& octave : space.octaves()) {
    if (levels.empty()) {
      levels.push_back({image.ptr<std::int16_t>(), static_cast<std::ptrdiff_t>(image.step1()), image.cols,
                        image.rows, 1, kCameraBlur, 0});
      levels.push_back(octave.levels[0]);
    }
    // The first level of another octave has the same blur as the last one before, but fewer pixels.
    levels.insert(levels.end(), octave.levels.begin() + 1, octave.levels.end());
  }
  return levels;
}

}  // namespace

PatchSift::PatchSift(const SiftOptions& options) : options_(options) { options_.check(); }

void PatchSift::describe(const cv::Mat& grey, int threads, Workspace& workspace, Features& features) const {
  describeOn(levelsOf(grey, threads, workspace), grey, threads, workspace, features);
}

void PatchSift::describeOn(const std::vector<ScaleLevel>& levels, const cv::Mat& grey, int threads,
                           Workspace&, Features& features) const {
  const std::vector<char> described =
      siftDescriptors(levels, features.frames, grey.size(), threads, features.descriptors);
  keepFeatures(described, features);
  if (options_.root) toRootSift(features.descriptors);
}

}  // namespace corrsel::core
