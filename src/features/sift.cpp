#include "corrsel/features/sift.h"

#include <opencv2/features2d.hpp>

namespace corrsel::core {

void SiftOptions::visit(OptionVisitor& visitor) {
  visitCap(visitor);
  visitor.integer({"octave_layers", 1, 10, "-", "SIFT: layers per octave"}, octave_layers);
  visitor.number({"contrast_threshold", 0, 1, "-", "SIFT: extrema weaker than this are dropped"},
                 contrast_threshold);
  visitor.number({"edge_threshold", 1, 100, "-", "SIFT: edge-like extrema are dropped; larger keeps more"},
                 edge_threshold);
  visitor.number({"sigma", 0.5, 5, "px", "SIFT: blur of the first octave"}, sigma);
  visitor.flag("root", "SIFT descriptor of any detector: RootSIFT, compared by the Hellinger kernel", root);
}

SiftDetector::SiftDetector(const SiftOptions& options)
    : OpenCvDetector(
          "sift",
          [options](const cv::Size&) {
            return cv::SIFT::create(options.spread ? 0 : options.max_features, options.octave_layers,
                                    options.contrast_threshold, options.edge_threshold, options.sigma);
          },
          4),
      options_(options) {
  options_.check();
}

void SiftDetector::detectAndDescribe(const cv::Mat& grey, int threads, Features& features) const {
  OpenCvDetector::detectAndDescribe(grey, threads, features);
  if (options_.root) toRootSift(features.descriptors);
}

void toRootSift(cv::Mat& descriptors) {
  for (int row = 0; row < descriptors.rows; ++row) {
    cv::Mat values = descriptors.row(row);
    const double total = cv::norm(values, cv::NORM_L1);
    if (total > 0) cv::sqrt(values / total, values);
  }
}

}  // namespace corrsel::core
