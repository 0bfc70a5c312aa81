#include "corrsel/reference/reference_selectors.h"

#include <mutex>
#include <vector>

#include "corrsel/reference/frame_votes.h"
#include "corrsel/reference/gaim.h"
#include "corrsel/reference/icf.h"
#include "corrsel/reference/lap.h"
#include "corrsel/reference/logos.h"
#include "corrsel/reference/mlesac.h"
#include "corrsel/reference/multigs.h"
#include "corrsel/reference/pnapsac.h"
#include "corrsel/reference/ranks.h"
#include "corrsel/reference/rfm_scan.h"
#include "corrsel/reference/rrwm.h"
#include "corrsel/reference/tlinkage.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::core {
namespace {

/// The one place where a selector of this library is announced. A name that is new here also stands in
/// src/selectors/factory.cpp and in reference_plugins.xml.
std::vector<SelectorFactory> referenceSelectors() {
  constexpr SelectorGroup kReference = SelectorGroup::kReference;
  const std::vector<double> thresholds = {1, 1.5, 2, 3, 5, 7, 10, 15, 20};  // px
  return {
      SelectorFactory::of<LapSelector>(kReference, "N log N", "Local affine preservation",
                                       {{"lambda", {0.2, 0.35, 0.5, 0.65, 0.8, 0.95, 1.1, 1.4, 1.8}}}),
      SelectorFactory::of<RanksSelector>(
          kReference, "N log N", "Multi-scale top K rank preservation",
          {{"lambda_second", {0.05, 0.1, 0.2, 0.28, 0.35, 0.45, 0.6, 0.8, 1}}}),
      SelectorFactory::of<RfmScanSelector>(
          kReference, "N^1.5", "Dense clusters of matches: RFM-SCAN",
          {{"second_epsilon", {0.01, 0.02, 0.04, 0.06, 0.08, 0.12, 0.2, 0.4, 0.8}}}),
      SelectorFactory::of<LogosSelector>(
          kReference, "N log N", "Local geometric support of rotations and scales; needs frames",
          {{"max_difference", {0.05, 0.1, 0.15, 0.2, 0.3, 0.45, 0.7, 1, 1.5}}}),
      SelectorFactory::of<FrameVotesSelector>(
          kReference, "N log N", "Votes of neighbouring local frames: HVIV, ACC",
          {{"share", {0.02, 0.05, 0.1, 0.15, 0.25, 0.35, 0.5, 0.7, 0.9}}}),
      SelectorFactory::of<GaimSelector>(kReference, "N log N",
                                        "Graph of neighbouring local frames: GAIM in a binary form",
                                        {{"theta", {0.05, 0.1, 0.2, 0.4, 0.8, 1.5, 3, 5, 8}}}),
      SelectorFactory::of<RrwmSelector>(kReference, "N^2", "Reweighted random walks over pairs of matches",
                                        {{"inflation", {1, 3, 5, 10, 20, 30, 40, 60, 100}}}),
      SelectorFactory::of<MultigsSelector>(kReference, "N",
                                           "Samples of matches that prefer the same hypotheses: Multi-GS",
                                           {{"threshold", thresholds}}),
      SelectorFactory::of<PnapsacSelector>(kReference, "N",
                                           "Samples from growing neighbourhoods: Progressive NAPSAC",
                                           {{"threshold", thresholds}}),
      SelectorFactory::of<MlesacSelector>(kReference, "N", "Models compared by their likelihood: MLESAC",
                                          {{"threshold", thresholds}}),
      SelectorFactory::of<IcfSelector>(kReference, "N",
                                       "Correspondence functions in both directions, reduced form",
                                       {{"last_threshold", thresholds}}),
      SelectorFactory::of<TlinkageSelector>(
          kReference, "N^2 log N", "Clusters of matches that prefer the same homographies; small inputs",
          {{"tau", thresholds}}),
  };
}

}  // namespace

void addReferenceSelectors() {
  static std::once_flag added;
  std::call_once(added, [] { addSelectors(referenceSelectors()); });
}

}  // namespace corrsel::core
