#include "features/detectors/sift.h"

#include <algorithm>
#include <cmath>
#include <opencv2/features2d.hpp>

namespace corrsel::core {

void SiftOptions::visit(OptionVisitor& visitor) const {
  visitCap(visitor);
  visitor.integer({"octave_layers", 1, 10, "-", "SIFT: layers per octave"}, &SiftOptions::octave_layers);
  visitor.number({"contrast_threshold", 0, 1, "-", "SIFT: extrema weaker than this are dropped"},
                 &SiftOptions::contrast_threshold);
  visitor.number({"edge_threshold", 1, 100, "-", "SIFT: edge-like extrema are dropped; larger keeps more"},
                 &SiftOptions::edge_threshold);
  visitor.number({"sigma", 0.5, 5, "px", "SIFT: blur of the first octave"}, &SiftOptions::sigma);
  visitor.flag("root", "SIFT descriptor of any detector: RootSIFT, square roots of its values",
               &SiftOptions::root);
}

SiftDetector::SiftDetector(const SiftOptions& options)
    : OpenCvDetector(
          "sift",
          [options](const cv::Size&, int most) {
            return cv::SIFT::create(most, options.octave_layers, options.contrast_threshold,
                                    options.edge_threshold, options.sigma);
          },
          4),
      options_(options) {
  options_.check();
}

void SiftDetector::detectAndDescribe(const cv::Mat& grey, int threads, Features& features) const {
  OpenCvDetector::detectAndDescribe(grey, threads, features);
  if (options_.root) toRootSift(features.descriptors);
}

std::vector<int> SiftDetector::shares(const cv::Size&, int most) const { return {most}; }

void SiftDetector::detectAndDescribeWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                                          Features& features) const {
  OpenCvDetector::detectAndDescribeWhere(grey, threads, allowed, features);
  if (options_.root) toRootSift(features.descriptors);
}

void toRootSift(cv::Mat& descriptors) {
  for (int row = 0; row < descriptors.rows; ++row) {
    auto* const values = descriptors.ptr<float>(row);
    double total = 0;
    for (int k = 0; k < descriptors.cols; ++k) total += values[k];
    if (!(total > 0)) continue;
    for (int k = 0; k < descriptors.cols; ++k) {
      values[k] = static_cast<float>(std::min(255.0, std::round(512 * std::sqrt(values[k] / total))));
    }
  }
}

}  // namespace corrsel::core
