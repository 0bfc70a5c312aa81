#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "benchmark/files.h"
#include "benchmark/ordered_json.h"
#include "benchmark/tables.h"
#include "corrsel/benchmark/results.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/evaluation/statistics.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;
using Json = OrderedJson;

/// Undefined numbers are null.
Json jsonOf(const CellValue& cell) {
  return std::visit(
      [](const auto& value) {
        if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
          return std::isfinite(value) ? Json(value) : Json(nullptr);
        } else {
          return Json(value);
        }
      },
      cell);
}

Json jsonOf(const RunState& state) {
  Json left_out = Json::array();
  for (const auto& [dataset, reason] : state.left_out_datasets) {
    left_out.push_back({{"dataset", dataset}, {"reason", reason}});
  }
  return {{"complete", state.complete()},
          {"interrupted", state.interrupted},
          {"pairs_done", state.pairs_done},
          {"pairs_total", state.pairs_total},
          {"pairs_failed", state.pairs_failed},
          {"shard", state.shard},
          {"peak_memory_mib", state.peak_memory_mib},
          {"left_out_datasets", left_out}};
}

/// The warnings that docs/evaluation.md describes.
Json jsonOf(const std::vector<TruthWarning>& warnings) {
  Json list = Json::array();
  for (const TruthWarning& warning : warnings) {
    const TruthCheck& counts = warning.counts;
    list.push_back({{"dataset", warning.id.dataset},
                    {"sequence", warning.id.sequence},
                    {"pair", warning.id.pair},
                    {"pairs", warning.pairs},
                    {"truth", toString(counts.kind)},
                    {"reading", counts.reading},
                    {"tolerance_px", counts.tolerance},
                    {"n_putative", counts.n_putative},
                    {"n_truth", counts.n_truth},
                    {"n_reading", counts.n_reading},
                    {"text", warning.text()}});
  }
  return list;
}

/// Sorts the lines of pairs.csv by the numbers of their pairs, which stages.csv has.
void sortPairs(const fs::path& folder) {
  std::map<PairId, std::size_t> numbers;
  for (const StageRow& row :
       stagesTable().intactRows(readTextFile((folder / stagesTable().file()).string()))) {
    if (row.number) numbers[row.id] = *row.number;
  }
  const std::string file = (folder / pairsTable().file()).string();
  const std::size_t first = pairsTable().indexOf("dataset");
  const std::vector<std::string> lines = completeLines(readTextFile(file));
  std::vector<std::pair<std::size_t, std::size_t>> order;  // number of the pair, line
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> fields = parseCsvLine(lines[i]);
    const auto found = numbers.find({fields.at(first), fields.at(first + 1), fields.at(first + 2)});
    order.emplace_back(found == numbers.end() ? std::numeric_limits<std::size_t>::max() : found->second, i);
  }
  if (std::is_sorted(order.begin(), order.end())) return;
  std::sort(order.begin(), order.end());
  std::string text = pairsTable().header() + "\n";
  for (const auto& [number, line] : order) text += lines[line] + "\n";
  writeFile(file, text);
}

}  // namespace

std::vector<SummaryRow> summarize(const std::vector<ResultRow>& rows) {
  // One pair's repetitions, averaged.
  struct PairValues {
    std::vector<double> precision, recall_paper, f_paper, recall_same_tau, f_same_tau;
  };
  struct Group {
    SummaryRow row;
    std::vector<PairId> order;
    std::map<PairId, PairValues> pairs;
    std::vector<double> confidences, seconds;
  };
  using GroupKey = std::tuple<std::string, std::string, std::string, std::string, std::string>;
  std::vector<Group> groups;
  std::map<GroupKey, std::size_t> index;
  for (const ResultRow& row : rows) {
    const GroupKey key{row.id.dataset, row.features, row.preselection, row.selector,
                       formatNumber(row.metrics.tau)};
    const auto [found, is_new] = index.emplace(key, groups.size());
    if (is_new) {
      groups.emplace_back();
      SummaryRow& head = groups.back().row;
      head.dataset = row.id.dataset;
      head.features = row.features;
      head.preselection = row.preselection;
      head.selector = row.selector;
      head.tau = row.metrics.tau;
    }
    Group& group = groups[found->second];
    if (!row.judged()) continue;
    group.seconds.push_back(row.select_seconds);
    group.confidences.push_back(row.confidence);
    if (row.n_ground_truth == 0) continue;
    const PairId pair = row.id;
    if (group.pairs.count(pair) == 0) group.order.push_back(pair);
    PairValues& values = group.pairs[pair];
    const auto add = [](std::vector<double>& list, double value) {
      if (!std::isnan(value)) list.push_back(value);
    };
    add(values.precision, row.metrics.precision);
    add(values.recall_paper, row.metrics.recall_paper);
    add(values.f_paper, row.metrics.f_paper);
    add(values.recall_same_tau, row.metrics.recall_same_tau);
    add(values.f_same_tau, row.metrics.f_same_tau);
  }
  std::vector<SummaryRow> summary;
  for (Group& group : groups) {
    const auto perPair = [&group](std::vector<double> PairValues::*member) {
      std::vector<double> means;
      for (const PairId& pair : group.order) {
        const std::vector<double>& values = group.pairs[pair].*member;
        if (!values.empty()) means.push_back(mean(values));
      }
      return means;
    };
    SummaryRow& row = group.row;
    const std::vector<double> f = perPair(&PairValues::f_paper);
    row.pairs = group.order.size();
    row.precision = mean(perPair(&PairValues::precision));
    row.recall_paper = mean(perPair(&PairValues::recall_paper));
    row.f_paper = mean(f);
    const Interval interval = bootstrapMean(f, kBootstrapSeed);
    row.f_low = interval.low;
    row.f_high = interval.high;
    row.recall_same_tau = mean(perPair(&PairValues::recall_same_tau));
    row.f_same_tau = mean(perPair(&PairValues::f_same_tau));
    row.confidence_median = quantile(group.confidences, 0.5);
    row.select_median = quantile(group.seconds, 0.5);
    row.select_p95 = quantile(group.seconds, 0.95);
    summary.push_back(row);
  }
  return summary;
}

std::vector<SummaryRow> writeSummary(const RunFolder& folder, const RunState& state) {
  const fs::path path(folder.path());
  sortPairs(path);
  const std::vector<SummaryRow> summary = summarize(folder.readRows());
  Json groups = Json::array();
  for (const SummaryRow& row : summary) {
    Json group;
    for (const CsvColumn<SummaryRow>& column : summaryTable().columns()) {
      group[column.name] = jsonOf(column.cell(row));
    }
    groups.push_back(group);
  }
  writeFile((path / summaryTable().file()).string(), summaryTable().text(summary));
  writeFile(
      (path / "summary.json").string(),
      Json{{"state", jsonOf(state)}, {"truth_warnings", jsonOf(folder.doubtfulTruths())}, {"groups", groups}}
              .dump(2) +
          "\n");
  return summary;
}

}  // namespace corrsel::core
