#pragma once

#include <string>

#include "features/detectors/detector.h"

namespace corrsel::core {

struct BlobOptions : DetectorOptions {
  double threshold = 4.0;    ///< weakest extremum, grey levels; a disc answers with 0.74 of its contrast
  double min_sigma = 2.0;    ///< smallest blob, px; a disc of radius r has sigma r / sqrt(2)
  double max_sigma = 40.0;   ///< largest blob, px
  int layers = 3;            ///< scales per octave
  double edge_ratio = 10.0;  ///< extrema with a larger ratio of principal curvatures are dropped

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// "blob": extrema over space and scale of the scale-normalised Laplacian sigma^2 (Lxx + Lyy), bright and
/// dark (Lindeberg, "Feature detection with automatic scale selection", IJCV 1998, sections 3 and 4), refined
/// by a quadratic fit over 3x3x3 samples. The diameter is 2 sqrt(2) sigma, that of the disc which answers
/// most at sigma; blobs that do not lie within the image are left out. The angle is the strongest gradient
/// direction around (Lowe, IJCV 2004, section 5). The first two octaves are searched in the
/// image's own pixels, only then it is halved. O(pixels); memory: the image as float and, per thread, some
/// 40 bytes per pixel of 700 rows.
class BlobDetector : public Detector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit BlobDetector(const BlobOptions& options = {});

  void detect(const cv::Mat& grey, int threads, Features& features) const override;
  std::string name() const override { return "blob"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  BlobOptions options_;
};

}  // namespace corrsel::core
