#include "benchmark/examples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "corrsel/evaluation/statistics.h"

namespace corrsel::core {
namespace {

/// F of every selector on one pair.
struct EvaluatedPair {
  PairId id;
  std::map<std::string, double> f;
  double best_f = 0;
};

/// A demand on a set of examples: it must have one of the pairs of `value`, preferably one with a high value.
struct Demand {
  std::map<std::size_t, double> value;  ///< by index of the pair
};

/// In order of the pairs' names.
std::vector<EvaluatedPair> evaluatedPairs(const std::vector<ResultRow>& rows, double tau) {
  std::map<PairId, std::map<std::string, std::vector<double>>> values;
  for (const ResultRow& row : rows) {
    const Metrics* const metrics =
        row.evaluated() && row.selector != "keep_all" ? row.metricsAt(tau) : nullptr;
    if (metrics == nullptr || std::isnan(metrics->f_paper)) continue;
    values[row.id][row.selector].push_back(metrics->f_paper);
  }
  std::vector<EvaluatedPair> pairs;
  for (auto& [id, selectors] : values) {
    EvaluatedPair pair;
    pair.id = id;
    for (auto& [selector, repetitions] : selectors) {
      // Sorted, so that the sum does not depend on the order of the rows.
      std::sort(repetitions.begin(), repetitions.end());
      pair.f[selector] = mean(repetitions);
      pair.best_f = std::max(pair.best_f, pair.f[selector]);
    }
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

std::vector<Demand> demandsOf(const std::vector<EvaluatedPair>& pairs) {
  std::map<std::string, Demand> datasets, successes, failures;
  // For selectors that never reach the thresholds: the highest F, and the largest (shortfall, -F), with their
  // pairs.
  std::map<std::string, std::pair<double, Demand>> best;
  std::map<std::string, std::pair<std::pair<double, double>, Demand>> worst;
  const auto keepHighest = [](auto& slot, const auto& rank, std::size_t place, double value) {
    auto& [highest, demand] = slot;
    if (demand.value.empty() || rank > highest) {
      highest = rank;
      demand.value.clear();
    }
    if (rank == highest) demand.value[place] = value;
  };
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    datasets[pairs[i].id.dataset].value[i] = 0;
    for (const auto& [selector, f] : pairs[i].f) {
      const double shortfall = pairs[i].best_f - f;
      if (isExampleSuccess(f)) successes[selector].value[i] = f;
      if (isExampleFailure(f, pairs[i].best_f)) failures[selector].value[i] = shortfall;
      keepHighest(best[selector], f, i, f);
      keepHighest(worst[selector], std::make_pair(shortfall, -f), i, shortfall);
    }
  }
  std::vector<Demand> demands;
  for (const auto& [selector, highest] : best) {
    demands.push_back(successes.count(selector) ? successes[selector] : highest.second);
    demands.push_back(failures.count(selector) ? failures[selector] : worst[selector].second);
  }
  for (const auto& [dataset, demand] : datasets) demands.push_back(demand);
  return demands;
}

}  // namespace

std::vector<PairId> chooseExamples(const std::vector<ResultRow>& rows, double tau, std::size_t max_pairs) {
  const std::vector<EvaluatedPair> pairs = evaluatedPairs(rows, tau);
  std::vector<Demand> open = demandsOf(pairs);
  const std::vector<Demand> demands = open;
  std::vector<std::size_t> chosen;
  while (!open.empty() && chosen.size() < max_pairs) {
    std::size_t best = 0;
    std::pair<std::size_t, double> best_gain{0, 0.0};
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      std::pair<std::size_t, double> gain{0, 0.0};
      for (const Demand& demand : open) {
        const auto found = demand.value.find(i);
        if (found == demand.value.end()) continue;
        ++gain.first;
        gain.second += found->second;
      }
      if (gain > best_gain) {
        best_gain = gain;
        best = i;
      }
    }
    chosen.push_back(best);
    const auto shown = [best](const Demand& demand) { return demand.value.count(best) > 0; };
    open.erase(std::remove_if(open.begin(), open.end(), shown), open.end());
  }
  // Later choices may cover everything for which an earlier one was made.
  for (std::size_t k = 0; open.empty() && k < chosen.size();) {
    const bool spare = std::all_of(demands.begin(), demands.end(), [&](const Demand& demand) {
      return std::any_of(chosen.begin(), chosen.end(), [&](std::size_t place) {
        return place != chosen[k] && demand.value.count(place) > 0;
      });
    });
    if (spare) {
      chosen.erase(chosen.begin() + static_cast<std::ptrdiff_t>(k));
    } else {
      ++k;
    }
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<PairId> ids;
  for (const std::size_t place : chosen) ids.push_back(pairs[place].id);
  return ids;
}

}  // namespace corrsel::core
