#include "corrsel/selectors/ransac.h"

#include "search/search.h"
#include "selectors/parts/model_choice.h"

namespace corrsel::core {

void RansacOptions::visit(OptionVisitor& visitor) const {
  visitParts(visitor,
             {0.01, "Inlier threshold: the error of a homography, Sampson distance of a fundamental matrix",
              1, "Hypotheses at most"});
}

Presets RansacSelector::presets() const {
  return {{"h", {{"model", "homography"}}},
          {"f", {{"model", "fundamental"}}},
          {"count", {{"score", "inlier_count"}}},
          {"mlesac", {{"score", "mlesac"}}},
          {"msac", {{"score", "msac"}}},
          {"lo", {{"local_optimization", "true"}}},
          {"prosac", {{"sampler", "prosac"}}},
          {"lo_prosac", {{"local_optimization", "true"}, {"sampler", "prosac"}}}};
}

void RansacSelector::run(const Correspondences& matches, Workspace&, Selection& result) const {
  if (options_.model == ModelKind::kNone) {
    searchEitherModel(matches, options_, options_.threshold, options_.threshold, result);
  } else {
    searchConsensus(matches, options_, options_.threshold, result);
  }
}

}  // namespace corrsel::core
