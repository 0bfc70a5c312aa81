#pragma once

#include <string>

#include "corrsel/reference/search_options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// Progressive NAPSAC: the search of `usac` with samples from growing neighbourhoods of the best matches,
/// which PROSAC follows.
///
/// Idea, Algorithm: reference/growing_neighbourhoods.h. The other parts are those of UsacSelector.
///
/// Input: coordinates and the column `distance` (and `second_distance`) or `probability`, without which
/// samples are uniform and the message reports it.
///
/// Options: `threshold` 0 means 5 px (homography) or 1.5 px (fundamental matrix), and `max_iterations` 0
/// means 60000 (homography) or 40000 (fundamental matrix).
///
/// Failure: statuses and score as for RansacSelector.
///
/// Cost: that of UsacSelector.
///
/// Source: Barath, Ivashechkin and Matas, arXiv:1906.02295.
class PnapsacSelector : public SelectorWithOptions<ReferenceSearchOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "pnapsac"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
