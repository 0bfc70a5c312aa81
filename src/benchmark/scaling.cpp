#include "benchmark/scaling.h"

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "corrsel/datasets/scene.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::core {
namespace {

struct Contestant {
  std::string spec;
  int threads;
  std::unique_ptr<Selector> selector;
};

/// A selector without the option runs the same code whatever the number of threads.
bool usesThreads(const Selector& selector) {
  const std::vector<OptionText> options = listOptions(selector.options());
  return std::any_of(options.begin(), options.end(),
                     [](const OptionText& option) { return option.name == "threads"; });
}

}  // namespace

std::vector<ScalingRow> measureScaling(const BenchmarkConfig& config, const std::atomic<bool>& stop) {
  std::vector<Contestant> contestants;
  for (const int threads : std::set<int>{1, config.threads}) {
    for (const std::string& spec : config.selectors) {
      const OptionMap common = {{"seed", std::to_string(config.seed)},
                                {"threads", std::to_string(threads)},
                                {"model", "homography"}};
      std::unique_ptr<Selector> selector = createSelector(spec, config.optionsOf(spec), common);
      if (threads > 1 && !usesThreads(*selector)) continue;
      contestants.push_back({spec, threads, std::move(selector)});
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
