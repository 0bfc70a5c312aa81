#include "features/detectors/sift.h"

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

namespace {

CvSiftOptions cvOptions(const SiftOptions& options) {
  CvSiftOptions result;
  static_cast<DetectorOptions&>(result) = options;
  result.octave_layers = options.octave_layers;
  result.contrast_threshold = options.contrast_threshold;
  result.edge_threshold = options.edge_threshold;
  result.sigma = options.sigma;
  result.root = options.root;
  return result;
}

}  // namespace

SiftDetector::SiftDetector(const SiftOptions& options)
    : CvSiftDetector(cvOptions(options), "sift"), options_(options) {
  options_.check();
}

}  // namespace corrsel::core
