#include "features/detectors/cv_orb.h"

#include <vector>

#include "features/detectors/orb.h"
#include "features/parts/image_pyramid.h"

namespace corrsel::core {

void CvOrbOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.number({"scale_factor", 1.05, 3, "-", "OpenCV's ORB: scale between pyramid levels"},
                 &CvOrbOptions::scale_factor);
  visitor.integer({"levels", 1, 16, "-", "OpenCV's ORB: levels of the pyramid"}, &CvOrbOptions::levels);
  visitor.integer({"fast_threshold", 0, 255, "grey levels", "OpenCV's ORB: smallest corner contrast"},
                  &CvOrbOptions::fast_threshold);
  visitor.integer({"patch_size", 5, 127, "px",
                   "OpenCV's ORB: side of the described patch; features nearer to the border are lost"},
                  &CvOrbOptions::patch_size);
}

namespace {

// OpenCV's ORB cannot keep all features: it always divides a number among its levels.
constexpr int kNoLimit = 1000000;

// OpenCV fails on a pyramid that shrinks to nothing.
int levelsOf(const CvOrbOptions& options, const cv::Size& size) {
  return usableLevels(size, options.scale_factor, options.levels, options.patch_size);
}

// As many levels as the image allows.
CreateOpenCv cvOrbCreator(const CvOrbOptions& options) {
  return [options](const cv::Size& size, int max_features) {
    return cv::ORB::create(max_features > 0 ? max_features : kNoLimit,
                           static_cast<float>(options.scale_factor), levelsOf(options, size),
                           options.patch_size, 0, 2, cv::ORB::HARRIS_SCORE, options.patch_size,
                           options.fast_threshold);
  };
}

}  // namespace

CvOrbDetector::CvOrbDetector(const CvOrbOptions& options)
    : OpenCvDetector("cv_orb", cvOrbCreator(options), options.patch_size, kFastDiameter / options.patch_size),
      options_(options) {
  options_.check();
}

std::vector<int> CvOrbDetector::shares(const cv::Size& image_size, int max_features) const {
  return levelShares(max_features, options_.scale_factor, levelsOf(options_, image_size));
}

}  // namespace corrsel::core
