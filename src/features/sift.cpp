#include "corrsel/features/sift.h"

#include <opencv2/features2d.hpp>

#include "corrsel/features/opencv_extractor.h"

namespace corrsel::core {

void SiftOptions::visit(OptionVisitor& visitor) {
  visitor.integer({"max_features", 0, 100000, "-", "SIFT: strongest features kept; 0 = no cap"},
                  max_features);
  visitor.integer({"octave_layers", 1, 10, "-", "SIFT: layers per octave"}, octave_layers);
  visitor.number({"contrast_threshold", 0, 1, "-", "SIFT: extrema weaker than this are dropped"},
                 contrast_threshold);
  visitor.number({"edge_threshold", 1, 100, "-", "SIFT: edge-like extrema are dropped; larger keeps more"},
                 edge_threshold);
  visitor.number({"sigma", 0.5, 5, "px", "SIFT: blur of the first octave"}, sigma);
}

SiftExtractor::SiftExtractor(const SiftOptions& options)
    : OpenCvExtractor(
          "sift+sift",
          [options](const cv::Size&) {
            return cv::SIFT::create(0, options.octave_layers, options.contrast_threshold,
                                    options.edge_threshold, options.sigma);
          },
          options.max_features, 4),
      options_(options) {
  options_.check();
}

}  // namespace corrsel::core
