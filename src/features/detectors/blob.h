#pragma once

#include <string>

#include "features/detectors/detector.h"

namespace corrsel::core {

struct BlobOptions : DetectorOptions {
  double threshold = 4.0;   ///< weakest extremum, grey levels; the response of a disc is 0.74 of its contrast
  double min_sigma = 2.0;   ///< smallest blob, px; a disc of radius r has sigma r / sqrt(2)
  double max_sigma = 40.0;  ///< largest blob, px
  int layers = 3;           ///< scales per octave
  double edge_ratio = 10.0;  ///< extrema with a larger ratio of principal curvatures are dropped

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// "blob": bright and dark blobs at their own scale.
///
/// Idea: The scale-normalised Laplacian sigma^2 (Lxx + Lyy) is extremal over space and scale at the centre of
/// a blob, at a scale that follows the blob's size.
///
/// Algorithm: Derivatives with errors of fourth order, extrema among the 26 neighbours in space and scale,
/// and a quadratic fit over 3x3x3 samples. The diameter is 2 sqrt(2) sigma, that of the disc whose response
/// is largest at sigma. The angle is the strongest direction of the gradients around the blob. The first two
/// octaves are searched in the image's own pixels; then the image is halved.
///
/// Input: 8-bit grey image.
///
/// Options: BlobOptions.
///
/// Failure: Blobs that do not lie completely inside the image are dropped. Images whose width or height is
/// below 8 px have no features.
///
/// Cost: O(pixels), in parallel over bands of 512 rows; the image as float and, per thread, about 40 bytes
/// per pixel of 700 rows.
///
/// Source: Lindeberg, "Feature detection with automatic scale selection", IJCV 1998, sections 3 and 4; angle:
/// Lowe, IJCV 2004, section 5.
class BlobDetector : public Detector {
 public:
  /// Throws std::invalid_argument for options out of range.
  explicit BlobDetector(const BlobOptions& options = {});

  void detect(const DetectionRequest& request, Features& features) const override;
  std::string name() const override { return "blob"; }
  const DetectorOptions& options() const override { return options_; }

 private:
  BlobOptions options_;
};

}  // namespace corrsel::core
