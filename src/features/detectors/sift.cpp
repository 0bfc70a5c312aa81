#include "features/detectors/sift.h"

#include <opencv2/features2d.hpp>

#include "features/parts/root_sift.h"

namespace corrsel::core {

void SiftOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
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

void SiftDetector::detect(const DetectionRequest& request, Features& features) const {
  OpenCvDetector::detect(request, features);
  if (request.describe && options_.root) toRootSift(features.descriptors);
}

std::vector<int> SiftDetector::shares(const cv::Size&, int most) const { return {most}; }

}  // namespace corrsel::core
