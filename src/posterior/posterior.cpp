#include "posterior/posterior.h"

#include <cstdint>
#include <numeric>
#include <vector>

#include "base/gather.h"
#include "posterior/match_probability.h"
#include "search/local_support.h"
#include "search/ordering.h"

namespace corrsel::core {
namespace {

/// Memory that is kept between calls.
struct PosteriorMemory {
  Ordering ordering;
  std::vector<std::uint32_t> rows, identity, best_first;
  Correspondences matches;  // in random order, like everything below
  std::vector<std::uint8_t> mask;
  LocalSupport support;
  MatchProbability probability;
};

}  // namespace

void computePosterior(const Correspondences& matches, Selection& selection, Workspace& workspace) {
  PosteriorMemory& memory = workspace.part<PosteriorMemory>();
  memory.ordering.shuffle(matches, 0, memory.rows);
  gather(matches, memory.rows, memory.matches);
  gather(selection.mask, memory.rows, memory.mask);
  memory.identity.resize(matches.size());
  std::iota(memory.identity.begin(), memory.identity.end(), 0U);
  if (!memory.ordering.byQuality(memory.matches, memory.identity, memory.best_first))
    memory.best_first = memory.identity;
  memory.support.compute(memory.matches, memory.best_first);
  memory.probability.compute({memory.matches, memory.support, memory.mask, selection.model_kind,
                              selection.model, selection.confidence});
  selection.sigma = memory.probability.sigma();
  selection.probability.resize(matches.size());
  for (std::size_t i = 0; i < matches.size(); ++i)
    selection.probability[memory.rows[i]] = memory.probability.probability()[i];
}

}  // namespace corrsel::core
