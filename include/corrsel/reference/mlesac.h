#pragma once

#include <string>

#include "corrsel/reference/search_options.h"
#include "corrsel/selectors/selector.h"

namespace corrsel::core {

/// MLESAC: the search of `ransac`, in which models compete by the likelihood of a mixture of inliers and
/// outliers.
///
/// Algorithm: errors of inliers are normal, and those of outliers are uniform (reference/error_mixture.h).
/// The threshold is the bound within which 95 % of the errors of inliers lie. An outlier may lie anywhere in
/// the box of the right points. A likelihood cannot be given up early, so only models whose MSAC cost is near
/// the lowest one are compared by it: at most 1.5 times the cost, and at least two thirds of what the model
/// saves in comparison with no inliers. (Where few matches are inliers, 1.5 times the cost excludes nothing.)
/// The other parts are those of RansacSelector.
///
/// Options: `threshold` 0 means 10 px, and `max_iterations` 0 means 2000.
///
/// Failure: statuses and score as for RansacSelector.
///
/// Cost: that of RansacSelector, and O(N) for each model whose likelihood is computed.
///
/// Source: Torr and Zisserman, CVIU 2000.
class MlesacSelector : public SelectorWithOptions<ReferenceSearchOptions> {
 public:
  using SelectorWithOptions::SelectorWithOptions;
  std::string name() const override { return "mlesac"; }

 protected:
  void run(const Correspondences& matches, Workspace& workspace, Selection& result) const override;
};

}  // namespace corrsel::core
