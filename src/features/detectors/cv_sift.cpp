#include "features/detectors/cv_sift.h"

#include <opencv2/core/version.hpp>
#include <opencv2/features2d.hpp>
#include <stdexcept>
#include <tuple>

#include "features/parts/root_sift.h"

namespace corrsel::core {
namespace {

CreateOpenCv cvSiftCreator(const CvSiftOptions& options) {
#if CV_VERSION_MAJOR > 4 || (CV_VERSION_MAJOR == 4 && CV_VERSION_MINOR >= 4)
  return [options](const cv::Size&, int max_features) {
    return cv::SIFT::create(max_features, options.octave_layers, options.contrast_threshold,
                            options.edge_threshold, options.sigma);
  };
#else
  static_cast<void>(options);
  return {};
#endif
}

}  // namespace

void CvSiftOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.integer({"octave_layers", 1, 10, "-", "OpenCV's SIFT: layers per octave"},
                  &CvSiftOptions::octave_layers);
  visitor.number({"contrast_threshold", 0, 1, "-", "OpenCV's SIFT: extrema weaker than this are dropped"},
                 &CvSiftOptions::contrast_threshold);
  visitor.number(
      {"edge_threshold", 1, 100, "-", "OpenCV's SIFT: edge-like extrema are dropped; larger keeps more"},
      &CvSiftOptions::edge_threshold);
  visitor.number({"sigma", 0.5, 5, "px", "OpenCV's SIFT: blur of the first octave"}, &CvSiftOptions::sigma);
  visitor.flag("root", "OpenCV's SIFT as descriptor: RootSIFT, square roots of its values",
               &CvSiftOptions::root);
}

void requireCvSift(const std::string& algorithm, int major, int minor, int revision) {
  if (std::tie(major, minor) >= std::make_tuple(4, 4)) return;
  throw std::invalid_argument(algorithm + " needs OpenCV 4.4 or newer, but this is OpenCV " +
                              std::to_string(major) + "." + std::to_string(minor) + "." +
                              std::to_string(revision) + "; use sift, which works with every version");
}

CvSiftDetector::CvSiftDetector(const CvSiftOptions& options)
    : OpenCvDetector("cv_sift", cvSiftCreator(options), 4), options_(options) {
  requireCvSift(name(), CV_VERSION_MAJOR, CV_VERSION_MINOR, CV_VERSION_REVISION);
  options_.check();
}

void CvSiftDetector::detect(const DetectionRequest& request, Features& features) const {
  OpenCvDetector::detect(request, features);
  if (request.describe && options_.root) toRootSift(features.descriptors);
}

std::vector<int> CvSiftDetector::shares(const cv::Size&, int max_features) const { return {max_features}; }

}  // namespace corrsel::core
