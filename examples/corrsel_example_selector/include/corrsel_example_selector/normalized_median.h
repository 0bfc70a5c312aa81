#pragma once

#include <corrsel/options.h>
#include <corrsel/selectors/selector.h>

#include <string>

namespace corrsel_example_selector {

/// Every option is named once, in visit(): corrsel takes range checks, command lines, listings and
/// config.yaml from there.
struct NormalizedMedianOptions : corrsel::core::OptionSet {
  int neighbours = 8;
  double threshold = 2.0;
  double noise = 0.1;

  void visit(corrsel::core::OptionVisitor& visitor) const override;
};

/// Compares the displacement of every match with those of its k nearest neighbours in the left image:
/// selected if |d - m| <= threshold * (r + noise), m being the median of the neighbours' displacements (of
/// each component) and r the median of their distances from m. The score is -|d - m| / (r + noise).
/// Westerweel and Scarano, "Universal outlier detection for PIV data", Experiments in Fluids 39 (2005).
///
/// Good where neighbours move alike and most of them are right: matches that have passed a ratio test. About
/// O(N k).
class NormalizedMedian : public corrsel::Selector {
 public:
  std::string name() const override { return "corrsel_example_selector/NormalizedMedian"; }
  const corrsel::core::OptionSet& options() const override { return options_; }
  void configure(const corrsel::core::OptionMap& options) override;

 protected:
  void run(const corrsel::core::Correspondences& matches, corrsel::core::Selection& result) const override;

 private:
  NormalizedMedianOptions options_;
};

}  // namespace corrsel_example_selector
