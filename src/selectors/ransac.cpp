#include "corrsel/selectors/ransac.h"

#include "search/selecting.h"

namespace corrsel::core {

RansacOptions::RansacOptions() {
  sampler = Sampler::kUniform;
  max_iterations = 2000;
}

void RansacOptions::visit(OptionVisitor& visitor) const {
  visitParts(visitor,
             {0.01, "Inlier threshold: the error of a homography, Sampson distance of a fundamental matrix",
              1, "Hypotheses at most"});
}

Presets RansacSelector::presets() const {
  return {{"h", {{"model", "homography"}}},
          {"f", {{"model", "fundamental"}}},
          {"count", {{"score", "inlier_count"}}},
          {"msac", {{"score", "msac"}}},
          {"lo", {{"local_optimization", "true"}}},
          {"prosac", {{"sampler", "prosac"}}},
          {"lo_prosac", {{"local_optimization", "true"}, {"sampler", "prosac"}}}};
}

void RansacSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  selectByConsensus(
      matches, {modelOf(options_.model, options_.error, workspace), proposalOf(options_.sampler, workspace)},
      parametersOf(options_), options_.max_seconds, workspace, result);
}

}  // namespace corrsel::core
