#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct LogosOptions : ConfidenceOptions {
  int k = 40;                   ///< neighbours in each image
  double max_difference = 0.3;  ///< of angles, rad, and of logarithms of scales
  bool global = true;           ///< keep only matches whose rotation is near the most frequent one

  void visit(OptionVisitor& visitor) const override;
};

/// LOGOS: local geometric support.
///
/// Idea: two neighbouring matches support each other if their frames turn and grow alike, and if the vector
/// between their points turns and grows like the frames.
///
/// Algorithm: theta_i and s_i are the rotation and the scale of the map that takes the left frame of match i
/// to the right one. Match j supports match i if it is one of the `k` matches nearest to i in the left image,
/// if its right point is one of the `k` distinct right points nearest to that of i, and if, with u = x_j -
/// x_i and v = x'_j - x'_i, neither of which is zero,
///
///     |theta_i - theta_j|, |angle(u, v) - theta_i|, |ln(s_i / s_j)|, |ln(|v| / (|u| s_i))| < max_difference.
///
/// Matches with at least one support are kept. With `global`, the three neighbouring bins of max_difference /
/// 3 that hold most of their rotations are found, and only matches whose rotation is closer to the mean
/// within these bins than max_difference are selected.
///
/// Input: coordinates and the local affine frames of both features. A match is set aside if a frame is not
/// finite, has no area or is more than 10 times longer than wide, or if one frame is a thousand times larger
/// than the other. `global` assumes one rotation of the whole image.
///
/// A right point that many outliers share is one neighbour. Otherwise, such crowds push the right
/// neighbours out of the lists (F on VGG with sift+sift is then 2 points lower). Points are distinct if they
/// differ after rounding to whole px.
///
/// Options: angles are compared modulo 2 pi everywhere, which the code in OpenCV's contrib modules does not
/// do for the mode. That code has k = 5 and a difference of 0.1 (preset `opencv`). It was made for matches of
/// quantised words, in which every feature has many candidates.
///
/// Presets: `opencv`.
///
/// Failure: missing frames give `unsupported_input`; no usable frame, or all left or all right points equal,
/// give `degenerate`. The score is the number of supports, NaN for matches that were set aside; iterations
/// are 1.
///
/// Cost: O(N log N + N k) time and O(N k) memory in the workspace.
///
/// Source: Lowry and Andreasson, LOGOS: local geometric support for high-outlier spatial verification, ICRA
/// 2018.
class LogosSelector : public SelectorWithOptions<LogosOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "logos"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
