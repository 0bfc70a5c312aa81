#pragma once

#include <string>

#include "corrsel/reference/search_options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// Multi-GS: the search of `usac` with samples of matches that prefer the same hypotheses.
///
/// Idea, Algorithm: reference/hypothesis_affinity.h. The other parts are those of UsacSelector.
///
/// Options: `threshold` 0 means 5 px (homography) or 1.5 px (fundamental matrix), and `max_iterations` 0
/// means 5000.
///
/// Failure: statuses and score as for RansacSelector.
///
/// Cost: O(N) per hypothesis.
///
/// Source: Chin, Yu and Suter, ECCV 2010 and PAMI 2012.
class MultigsSelector : public SelectorWithOptions<ReferenceSearchOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "multigs"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
