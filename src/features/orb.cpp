#include "corrsel/features/orb.h"

#include <algorithm>
#include <opencv2/features2d.hpp>

#include "corrsel/features/opencv_extractor.h"

namespace corrsel::core {

void OrbOptions::visit(OptionVisitor& visitor) {
  visitor.integer({"max_features", 1, 100000, "-", "ORB: strongest features kept"}, max_features);
  visitor.number({"scale_factor", 1.05, 3, "-", "ORB: scale between pyramid levels"}, scale_factor);
  visitor.integer({"levels", 1, 16, "-", "ORB: levels of the pyramid"}, levels);
  visitor.integer({"fast_threshold", 0, 255, "grey levels", "ORB: smallest corner contrast"}, fast_threshold);
  visitor.integer({"patch_size", 5, 127, "px",
                   "ORB: side of the described patch; features nearer to the border are lost"},
                  patch_size);
}

namespace {

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

}  // namespace

OrbExtractor::OrbExtractor(const OrbOptions& options)
    : OpenCvExtractor(
          "orb+orb",
          [options](const cv::Size& size) {
            return cv::ORB::create(options.max_features, static_cast<float>(options.scale_factor),
                                   usableLevels(options, size), options.patch_size, 0, 2,
                                   cv::ORB::HARRIS_SCORE, options.patch_size, options.fast_threshold);
          },
          options.max_features, options.patch_size),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
