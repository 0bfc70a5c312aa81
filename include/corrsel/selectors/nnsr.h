#pragma once

#include <string>

#include "corrsel/selectors/selector.h"

namespace corrsel::core {

struct NnsrOptions : ConfidenceOptions {
  double fallback = 0.8;  ///< threshold where Otsu is undefined (one match, equal ratios); Lowe, IJCV 2004
  double min_threshold = 0.0;  ///< Otsu's threshold is raised to at least this ratio
  double max_threshold = 1.0;  ///< Otsu's threshold is lowered to at most this ratio

  void visit(OptionVisitor& visitor) const override;
  void check() const override;
};

/// Nearest-neighbour similarity ratio.
///
/// Idea: the nearest descriptor of a correct match is clearly closer than the second nearest.
///
/// Algorithm: r = d1 / d2 is the ratio of the two descriptor distances (not of their squares). A match is
/// accepted if r <= t. The threshold t is found for each pair by Otsu's method on its ratios,
/// with 256 bins over [0, 1].
///
/// Input: the columns `distance` and `second_distance`. Matches without a ratio (no second neighbour, d2 =
/// 0, or a distance that is not finite) are rejected and take no part in finding the threshold.
///
/// Presets: `lowe` is the fixed threshold 0.8.
///
/// Failure: without one of the columns the status is `unsupported_input`. Where Otsu's method is undefined
/// (one match, equal ratios), the threshold is `fallback`. The score is 1 - r, and 0 without a ratio.
///
/// Cost: O(N) time, O(N) memory.
///
/// Source: Lowe, IJCV 2004; the threshold as in Zhao et al. (the paper), Eq. 1 and its table of
/// parameters.
class NnsrSelector : public SelectorWithOptions<NnsrOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "nnsr"; }
  Presets presets() const override;

 protected:
  std::string missingInput(const Correspondences& matches) const override;
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
