#include "corrsel/selectors/planes.h"

#include <string>
#include <vector>

#include "base/deadline.h"
#include "search/homography_model.h"
#include "search/ordering.h"
#include "search/selecting.h"
#include "selectors/parts/sequential_planes.h"

namespace corrsel::core {

PlanesOptions::PlanesOptions() {
  sampler = Sampler::kLocal;
  max_iterations = 1000;
  min_confidence = kSignificantConfidence;
}

void PlanesOptions::visit(OptionVisitor& visitor) const {
  visitSampler(visitor);
  visitor.flag("frames", "Use local affine frames where there are any, in place of samples",
               &PlanesOptions::frames);
  visitor.integer({"max_iterations", 1, 10000000, "-", "Hypotheses per plane at most"},
                  &PlanesOptions::max_iterations);
  visitor.integer({"max_planes", 1, 100, "-", "Planes at most"}, &PlanesOptions::max_planes);
  visitor.number({"relative_cut", 0, 1, "-",
                  "Smallest confidence of a further plane, relative to that of the first one"},
                 &PlanesOptions::relative_cut);
  visitor.number({"widen", 1, 10, "-",
                  "Inlier threshold, in units of the threshold at which the plane is the most significant"},
                 &PlanesOptions::widen);
  visitor.number({"min_threshold", 0.01, 100, "px", "Smallest inlier threshold"},
                 &PlanesOptions::min_threshold);
  visitor.number(
      {"max_threshold", 0.01, 100, "px", "Largest inlier threshold, if it is above the smallest one"},
      &PlanesOptions::max_threshold);
  visitSeedAndTime(visitor);
  visitConfidence(visitor);
}

Presets PlanesSelector::presets() const { return {{"first", {{"max_planes", "1"}}}}; }

namespace {

/// Memory that is kept between calls.
struct PlanesMemory {
  Ordering ordering;
  std::vector<std::uint32_t> rows;
  SequentialPlanes search;
};

}  // namespace

void PlanesSelector::run(const Correspondences& matches, Workspace& workspace, Selection& result) const {
  const Deadline deadline(options_.max_seconds);
  const bool frames = options_.frames && !matches.left_frame.empty() && !matches.right_frame.empty();
  const HomographyModel model;
  const SearchParts parts = {
      model, proposalOf(frames ? PlanesOptions::Sampler::kFrames : options_.sampler, workspace)};
  if (!isEnough(matches.size(), model, result)) return;
  PlanesMemory& work = workspace.part<PlanesMemory>();
  work.ordering.shuffle(matches, static_cast<std::uint64_t>(options_.seed), work.rows);
  SequentialPlanes& search = work.search;
  search.find(matches, work.rows, nullptr, parts, options_, deadline, workspace, result);
  reportEnd(search.outcome(), options_.max_seconds, result);
  const std::int32_t planes = search.planes();
  if (planes == 0) {
    if (result.status == Status::kOk) {
      result.status = Status::kNoModel;
      result.message = "no homography agrees with more matches than chance explains";
    }
    return;
  }
  result.model = search.model();
  result.model_kind = model.traits.kind;
  result.confidence = search.confidence();
  result.group = search.group();
  result.score.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i) {
    result.mask[i] = result.group[i] >= 0 ? 1 : 0;
    result.score[i] = static_cast<float>(-search.errors()[i]);
  }
  addRemark(result, std::to_string(planes) + (planes == 1 ? " plane" : " planes"));
}

}  // namespace corrsel::core
