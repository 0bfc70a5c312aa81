#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <ostream>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/ordered_json.h"
#include "base/text.h"
#include "benchmark/files.h"
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

/// Rows as objects with the names of the columns.
template <class Row>
Json jsonOf(const CsvTable<Row>& table, const std::vector<Row>& rows) {
  Json list = Json::array();
  for (const Row& row : rows) {
    Json object;
    for (const CsvColumn<Row>& column : table.columns()) object[column.name] = jsonOf(column.cell(row));
    list.push_back(object);
  }
  return list;
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

/// Numbers of the pairs in the undivided run.
std::map<PairId, std::size_t> numbersOfPairs(const fs::path& folder) {
  std::map<PairId, std::size_t> numbers;
  for (const StageRow& row :
       stagesTable().intactRows(readTextFile((folder / stagesTable().file()).string()))) {
    if (row.number) numbers[row.id] = *row.number;
  }
  return numbers;
}

/// Sorts the lines of a table by the numbers of their pairs. Damaged lines come last.
template <class Row>
void sortByPair(const fs::path& folder, const CsvTable<Row>& table,
                const std::map<PairId, std::size_t>& numbers) {
  // Neighbouring lines of one pair: they stay together, and of each part only its place is in memory.
  struct Part {
    std::size_t number, begin, size;
  };
  const std::string file = (folder / table.file()).string();
  const std::size_t first = table.indexOf("dataset");
  std::vector<Part> parts;
  const std::size_t head = table.head().size();
  std::size_t place = 0;
  forEachLine(file, [&](const std::string& line) {
    const std::size_t begin = place;
    place += line.size() + 1;
    if (begin < head) return;
    const std::vector<std::string> fields = parseCsvLine(line);
    const auto found = fields.size() < first + 3
                           ? numbers.end()
                           : numbers.find({fields[first], fields[first + 1], fields[first + 2]});
    const std::size_t number =
        found == numbers.end() ? std::numeric_limits<std::size_t>::max() : found->second;
    if (parts.empty() || parts.back().number != number) parts.push_back({number, begin, 0});
    parts.back().size += place - begin;
  });
  const auto before = [](const Part& a, const Part& b) { return a.number < b.number; };
  if (std::is_sorted(parts.begin(), parts.end(), before)) return;
  std::stable_sort(parts.begin(), parts.end(), before);
  std::ifstream in(file, std::ios::binary);
  writeFile(file, [&](std::ostream& out) {
    out << table.head();
    for (const Part& part : parts) {
      std::string text(part.size, '\0');
      in.seekg(static_cast<std::streamoff>(part.begin));
      in.read(&text[0], static_cast<std::streamsize>(part.size));
      out << text;
    }
  });
}

/// The rows of summary.csv from the rows of pairs.csv, of which it keeps 70 bytes for each tolerance.
class Summary {
 public:
  void add(const ResultRow& row) {
    for (const Metrics& m : row.metrics) {
      Group& group = groupOf(row, m.tau);
      if (!row.evaluated()) continue;
      group.seconds.push_back(row.select_seconds);
      if (!std::isnan(row.confidence)) group.confidences.push_back(row.confidence);
      if (row.n_ground_truth == 0) continue;
      group.entries.push_back(
          {numberOf(row.id), {m.precision, m.recall_paper, m.f_paper, m.recall_same_tau, m.f_same_tau}});
    }
  }

  std::vector<SummaryRow> rows() {
    std::vector<SummaryRow> summary;
    for (Group& group : groups_) {
      SummaryRow& row = group.row;
      const std::vector<std::vector<std::size_t>> pairs = entriesOfPairs(group);
      // The repetitions of a pair are averaged.
      const auto perPair = [&](std::size_t measure) {
        std::vector<double> means;
        for (const std::vector<std::size_t>& entries : pairs) {
          std::vector<double> values;
          for (const std::size_t i : entries) {
            const double value = group.entries[i].values[measure];
            if (!std::isnan(value)) values.push_back(value);
          }
          if (!values.empty()) means.push_back(mean(values));
        }
        return means;
      };
      const std::vector<double> f = perPair(2);
      row.pairs = pairs.size();
      row.precision = mean(perPair(0));
      row.recall_paper = mean(perPair(1));
      row.f_paper = mean(f);
      const Interval interval = bootstrapMean(f, kBootstrapSeed);
      row.f_low = interval.low;
      row.f_high = interval.high;
      row.recall_same_tau = mean(perPair(3));
      row.f_same_tau = mean(perPair(4));
      row.confidence_median = quantile(group.confidences, 0.5);
      row.select_median = quantile(group.seconds, 0.5);
      row.select_p95 = quantile(group.seconds, 0.95);
      summary.push_back(row);
    }
    return summary;
  }

 private:
  struct Entry {
    std::size_t pair;
    std::array<double, 5> values;  ///< precision, recall_paper, f_paper, recall_same_tau, f_same_tau
  };
  struct Group {
    SummaryRow row;
    std::vector<Entry> entries;
    std::vector<double> confidences, seconds;
  };
  using GroupKey = std::tuple<std::string, std::string, std::string, std::string, std::string>;

  Group& groupOf(const ResultRow& row, double tau) {
    const GroupKey key{row.id.dataset, row.features, row.preselection, row.selector, formatNumber(tau)};
    const auto [found, is_new] = index_.emplace(key, groups_.size());
    if (is_new) {
      groups_.emplace_back();
      SummaryRow& head = groups_.back().row;
      head.dataset = row.id.dataset;
      head.features = row.features;
      head.preselection = row.preselection;
      head.selector = row.selector;
      head.tau = tau;
    }
    return groups_[found->second];
  }

  std::size_t numberOf(const PairId& pair) { return numbers_.emplace(pair, numbers_.size()).first->second; }

  /// The entries of each pair of a group, pairs in the order of their appearance.
  std::vector<std::vector<std::size_t>> entriesOfPairs(const Group& group) const {
    std::vector<std::vector<std::size_t>> pairs;
    std::unordered_map<std::size_t, std::size_t> places;
    for (std::size_t i = 0; i < group.entries.size(); ++i) {
      const auto [found, is_new] = places.emplace(group.entries[i].pair, pairs.size());
      if (is_new) pairs.emplace_back();
      pairs[found->second].push_back(i);
    }
    return pairs;
  }

  std::vector<Group> groups_;
  std::map<GroupKey, std::size_t> index_;
  std::map<PairId, std::size_t> numbers_;
};

}  // namespace

std::vector<SummaryRow> summarize(const std::vector<ResultRow>& rows) {
  Summary summary;
  for (const ResultRow& row : rows) summary.add(row);
  return summary.rows();
}

std::vector<SummaryRow> writeSummary(const RunFolder& folder, const RunState& state) {
  const fs::path path(folder.path());
  const std::map<PairId, std::size_t> numbers = numbersOfPairs(path);
  sortByPair(path, pairsTable(folder.tolerances()), numbers);
  sortByPair(path, posesTable(), numbers);
  sortByPair(path, truthChecksTable(), numbers);
  sortByPair(path, savedMatchesTable(), numbers);
  Summary means;
  folder.forEachRow([&means](const ResultRow& row) { means.add(row); });
  const std::vector<SummaryRow> summary = means.rows();
  const std::vector<PoseSummaryRow> poses = summarizePoses(folder.readPoses());
  writeFile((path / poseSummaryTable().file()).string(), poseSummaryTable().text(poses));
  writeFile((path / summaryTable().file()).string(), summaryTable().text(summary));
  writeFile((path / "summary.json").string(), Json{{"state", jsonOf(state)},
                                                   {"truth_warnings", jsonOf(folder.doubtfulTruths())},
                                                   {"groups", jsonOf(summaryTable(), summary)},
                                                   {"poses", jsonOf(poseSummaryTable(), poses)}}
                                                      .dump(2) +
                                                  "\n");
  return summary;
}

}  // namespace corrsel::core
