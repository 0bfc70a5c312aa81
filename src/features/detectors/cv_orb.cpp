#include "features/detectors/cv_orb.h"

#include <algorithm>
#include <cmath>
#include <vector>

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

// OpenCV's ORB cannot keep all features: it always divides a number among its levels.
constexpr int kNoLimit = 1000000;

// OpenCV fails on a pyramid that shrinks to nothing.
int usableCvOrbLevels(const CvOrbOptions& options, const cv::Size& size) {
  const double smallest = options.patch_size + 1.0;
  int levels = 1;
  for (double side = std::min(size.width, size.height) / options.scale_factor;
       levels < options.levels && side > smallest; side /= options.scale_factor) {
    ++levels;
  }
  return levels;
}

CreateOpenCv cvOrbCreator(const CvOrbOptions& options) {
  return [options](const cv::Size& size, int most) {
    return cv::ORB::create(most > 0 ? most : kNoLimit, static_cast<float>(options.scale_factor),
                           usableCvOrbLevels(options, size), options.patch_size, 0, 2, cv::ORB::HARRIS_SCORE,
                           options.patch_size, options.fast_threshold);
  };
}

CvOrbDetector::CvOrbDetector(const CvOrbOptions& options, const std::string& name)
    : OpenCvDetector(name, cvOrbCreator(options), options.patch_size, kFastDiameter / options.patch_size),
      options_(options) {
  options_.check();
}

std::vector<int> CvOrbDetector::shares(const cv::Size& image_size, int most) const {
  const int levels = usableCvOrbLevels(options_, image_size);
  const double factor = 1 / options_.scale_factor;
  double share = most * (1 - factor) / (1 - std::pow(factor, levels));
  std::vector<int> result;
  int left = most;
  for (int level = 1; level < levels; ++level, share *= factor) {
    result.push_back(std::min(cvRound(share), left));
    left -= result.back();
  }
  result.push_back(left);
  return result;
}

}  // namespace corrsel::core
