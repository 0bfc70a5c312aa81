#pragma once

#include <string>

#include "corrsel/features/detector.h"

namespace corrsel::core {

struct AsiftOptions : DetectorOptions {
  int tilts = 5;                     ///< simulated tilts sqrt(2)^k, k = 1..tilts, beside the image itself
  double rotation_step = 72;         ///< between the views of tilt t: this / t, degrees
  double sigma = 1.6;                ///< blur of the first octave, px
  int octave_layers = 3;             ///< layers per octave
  double contrast_threshold = 0.04;  ///< weak extrema are dropped; divided by octave_layers inside
  double edge_threshold = 10;        ///< edge-like extrema are dropped; larger keeps more
  double margin = 6;                 ///< simulated views: distance from the image border, in radii
  double merge_distance = 0.5;
  double merge_shape = 0.4;
  double max_megapixels = 4;  ///< larger images are shrunk to this

  void visit(OptionVisitor& visitor) override;
};

class AsiftDetector : public Detector {
 public:
  explicit AsiftDetector(const AsiftOptions& options = {});

  void detect(const cv::Mat& grey, int threads, Features& features) const override;

  void extract(const cv::Mat& grey, int threads, Features& features) const;

  std::string name() const override { return "asift"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  AsiftOptions options_;
};

}  // namespace corrsel::core
