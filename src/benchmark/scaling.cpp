#include "benchmark/scaling.h"

#include <memory>
#include <set>
#include <string>

#include "corrsel/datasets/scene.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::core {
namespace {

struct Contestant {
  std::string spec;
  int threads;
  std::unique_ptr<Selector> selector;
};

}  // namespace

std::vector<ScalingRow> measureScaling(const BenchmarkConfig& config, const std::atomic<bool>& stop) {
  std::vector<Contestant> contestants;
  for (const int threads : std::set<int>{1, config.threads}) {
    for (const std::string& spec : config.selectors) {
      const OptionMap common = {{"seed", std::to_string(config.seed)},
                                {"threads", std::to_string(threads)},
                                {"model", "homography"}};
      contestants.push_back({spec, threads, createSelector(spec, config.optionsOf(spec), common)});
    }
  }
  std::vector<ScalingRow> rows;
  for (const int n : kScalingSizes) {
    SceneSpec spec;
    spec.n = static_cast<std::size_t>(n);
    for (int round = -1; round < kScalingRounds; ++round) {
      spec.seed = static_cast<std::uint64_t>(round + 1);
      const Correspondences matches = makeScene(spec).matches;
      for (const Contestant& contestant : contestants) {
        if (stop) return {};
        const Selection selection = contestant.selector->select(matches);
        if (round < 0) continue;
        rows.push_back({contestant.spec, contestant.threads, spec.n, round, selection.n_selected,
                        selection.status, selection.seconds});
      }
    }
  }
  return rows;
}

}  // namespace corrsel::core
