#pragma once

#include <corrsel/options.h>
#include <corrsel/selectors/selector.h>

#include <string>

namespace corrsel_example_selector {

/// visit() describes every option once. corrsel derives range checks, command lines, listings and config.yaml
/// from it.
struct NormalizedMedianOptions : corrsel::core::OptionSet {
  int neighbours = 8;
  double threshold = 2.0;
  double noise = 0.1;

  void visit(corrsel::core::OptionVisitor& visitor) const override;
};

/// Normalized median test.
///
/// Idea: a correct match moves like its neighbours.
/// Algorithm: d is the displacement of a match. m is the median, by component, of the displacements of its k
/// nearest neighbours in the left image, and r is the median of their distances from m. The match is selected
/// if |d - m| <= threshold * (r + noise). Its score is -|d - m| / (r + noise). Input: coordinates only.
/// Neighbours should move alike and most of them should be correct, as after a ratio test. Failure: too_few
/// for at most k matches. Cost: about O(N k). Source: Westerweel and Scarano, "Universal outlier detection
/// for PIV data", Experiments in Fluids 39 (2005).
class NormalizedMedian : public corrsel::SelectorWithOptions<NormalizedMedianOptions> {
 public:
  std::string name() const override { return "corrsel_example_selector/NormalizedMedian"; }
  corrsel::core::Presets presets() const override;

 protected:
  void run(const corrsel::core::Correspondences& matches, corrsel::core::Workspace& workspace,
           corrsel::core::Selection& result) const override;
};

}  // namespace corrsel_example_selector
