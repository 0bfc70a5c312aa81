#pragma once

#include <cstdint>
#include <vector>

#include "corrsel/selectors/auto.h"

namespace corrsel::core {

/// The inlier thresholds of a call.
///
/// Idea: within wide limits, the thresholds of precise features do not matter, because most outliers are far
/// away. Where the noise is larger than they allow, they lose inliers.
///
/// Algorithm: a threshold that the user has given is kept. Otherwise it begins at 5 px for a homography and
/// 1.5 px for a fundamental matrix. Once a model is known, the noise of its inliers is estimated
/// (noise_scale.h) among the errors up to three times the threshold. If 97 % of them need more than the
/// threshold, it becomes as large as they need, but at most 1.5 times (homography) or three times as large as
/// before. Without the bound of 7.5 px for a plane, blurred images lose up to 12 of F at 5 px.
///
/// Sensitivity: smaller thresholds for precise features gain nothing on any dataset
/// (docs/studies/parallax.md).
class Thresholds {
 public:
  Thresholds() = default;
  explicit Thresholds(const AutoOptions& options);

  /// @param errors  squared errors of all matches under the best model, px^2
  void adaptHomography(const std::vector<double>& errors);
  void adaptFundamental(const std::vector<double>& errors);

  double homography = 0, fundamental = 0;  ///< px

 private:
  bool adapts_homography_ = false, adapts_fundamental_ = false;
};

/// Writes 1 for the matches whose squared error is within a threshold, and 0 for the others.
void selectWithin(const std::vector<double>& errors, double threshold, std::vector<std::uint8_t>& mask);

}  // namespace corrsel::core
