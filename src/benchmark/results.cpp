#include "corrsel/benchmark/results.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <numeric>
#include <tuple>

#include "base/text.h"
#include "corrsel/evaluation/statistics.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPairsHeader =
    "dataset,sequence,pair,features,preselection,selector,tau_px,n_left,n_right,n_putative,n_ground_truth,n_"
    "selected,"
    "n_correct,precision,recall_paper,recall_same_tau,f_paper,f_same_tau,status,seed,detect_s,describe_s,"
    "match_s,"
    "select_s";
constexpr std::size_t kPairsColumns = 24;

double numberOrNan(const std::string& text, const char* column) {
  return text.empty() ? kUndefined : parseNumber(text, column);
}

std::size_t count(const std::string& text, const char* column) {
  const double value = numberOrNan(text, column);
  if (std::isnan(value)) return 0;
  // Beyond 2^53 not every whole number is a double.
  if (!(value >= 0 && value <= 9007199254740992.0) || value != std::floor(value)) {
    throw std::invalid_argument(std::string(column) + ": '" + text + "' is not a count");
  }
  return static_cast<std::size_t>(value);
}

bool near(double a, double b) { return std::isnan(a) ? std::isnan(b) : std::abs(a - b) <= 1e-6; }

/// Harmonic mean of correct / selected and correct / inliers; NaN where there is no inlier.
double fOfCounts(double correct, double selected, double inliers) {
  return inliers > 0 ? 2 * correct / (selected + inliers) : kUndefined;
}

/// What in a row cannot be; empty for a row as the benchmark writes it.
std::string contradictionIn(const ResultRow& row) {
  const Metrics& m = row.metrics;
  const auto exceeds = [](const char* part, std::size_t a, const char* whole, std::size_t b) {
    return std::string(part) + " = " + std::to_string(a) + " exceeds " + whole + " = " + std::to_string(b);
  };
  const auto differs = [](const char* name, double value, const std::string& of, double expected) {
    const auto text = [](double number) {
      return std::isnan(number) ? std::string("(empty)") : formatNumber(number);
    };
    return std::string(name) + " = " + text(value) + " instead of " + of + " = " + text(expected);
  };
  if (m.tau < 0 || std::isinf(m.tau)) return "tau_px = " + formatNumber(m.tau) + " is no tolerance";
  for (const auto& [name, seconds] : {std::pair{"detect_s", row.detect_seconds},
                                      {"describe_s", row.describe_seconds},
                                      {"match_s", row.match_seconds},
                                      {"select_s", row.select_seconds}}) {
    if (seconds < 0 || std::isinf(seconds)) {
      return std::string(name) + " = " + formatNumber(seconds) + " is no time";
    }
  }
  if (row.n_ground_truth > row.n_putative) {
    return exceeds("n_ground_truth", row.n_ground_truth, "n_putative", row.n_putative);
  }
  if (!row.judged()) {
    const bool empty = row.n_selected == 0 && m.n_correct == 0 && std::isnan(m.precision) &&
                       std::isnan(m.recall_paper) && std::isnan(m.recall_same_tau) && std::isnan(m.f_paper) &&
                       std::isnan(m.f_same_tau) && std::isnan(row.select_seconds);
    return empty ? "" : "status " + toString(row.status) + " beside numbers of a selection";
  }
  if (row.n_selected > row.n_putative) {
    return exceeds("n_selected", row.n_selected, "n_putative", row.n_putative);
  }
  if (m.n_correct > row.n_selected) {
    return exceeds("n_correct", m.n_correct, "n_selected", row.n_selected);
  }
  // A pair about which nothing is known.
  const bool no_truth = row.n_ground_truth == 0 && m.n_correct == 0 && std::isnan(m.precision) &&
                        std::isnan(m.recall_paper) && std::isnan(m.recall_same_tau) &&
                        std::isnan(m.f_paper) && std::isnan(m.f_same_tau);
  if (no_truth) return "";
  const double correct = static_cast<double>(m.n_correct), selected = static_cast<double>(row.n_selected),
               inliers = static_cast<double>(row.n_ground_truth);
  const double precision = row.n_selected > 0 ? correct / selected : kUndefined;
  if (!near(m.precision, precision)) {
    return differs("precision", m.precision, "n_correct / n_selected", precision);
  }
  const double recall = row.n_ground_truth > 0 ? correct / inliers : kUndefined;
  if (!near(m.recall_paper, recall)) {
    return differs("recall_paper", m.recall_paper, "n_correct / n_ground_truth", recall);
  }
  const double f = fOfCounts(correct, selected, inliers);
  if (!near(m.f_paper, f)) return differs("f_paper", m.f_paper, "the F of the counts", f);
  const bool none_correct = m.n_correct == 0, undefined = std::isnan(m.recall_same_tau);
  const bool possible =
      none_correct ? undefined || m.recall_same_tau == 0 : m.recall_same_tau > 0 && m.recall_same_tau <= 1;
  if (!possible) {
    return "recall_same_tau = " + formatNumber(m.recall_same_tau) +
           " with n_correct = " + std::to_string(m.n_correct);
  }
  double f_same_tau = undefined ? kUndefined : 0.0;
  if (!none_correct) f_same_tau = fOfCounts(correct, selected, correct / m.recall_same_tau);
  if (!near(m.f_same_tau, f_same_tau)) {
    return differs("f_same_tau", m.f_same_tau, "the F of precision and recall_same_tau", f_same_tau);
  }
  return "";
}

}  // namespace

const char* pairsHeader() { return kPairsHeader; }

std::string ResultRow::toCsv() const {
  const bool numbers = judged();
  const auto number = [numbers](double value) { return numbers ? formatNumber(value) : std::string(); };
  const auto selected = [numbers](std::size_t value) {
    return numbers ? std::to_string(value) : std::string();
  };
  return csvLine({id.dataset,
                  id.sequence,
                  id.pair,
                  features,
                  preselection,
                  selector,
                  formatNumber(metrics.tau),
                  std::to_string(n_left),
                  std::to_string(n_right),
                  std::to_string(n_putative),
                  std::to_string(n_ground_truth),
                  selected(n_selected),
                  selected(metrics.n_correct),
                  number(metrics.precision),
                  number(metrics.recall_paper),
                  number(metrics.recall_same_tau),
                  number(metrics.f_paper),
                  number(metrics.f_same_tau),
                  toString(status),
                  std::to_string(seed),
                  formatNumber(detect_seconds),
                  formatNumber(describe_seconds),
                  formatNumber(match_seconds),
                  number(select_seconds)});
}

ResultRow ResultRow::fromCsv(const std::string& line) {
  const std::vector<std::string> f = parseCsvLine(line);
  if (f.size() != kPairsColumns) {
    throw std::invalid_argument("row has " + std::to_string(f.size()) + " columns instead of " +
                                std::to_string(kPairsColumns) + ": " + line);
  }
  ResultRow row;
  row.id = {f[0], f[1], f[2]};
  row.features = f[3];
  row.preselection = f[4];
  row.selector = f[5];
  row.metrics.tau = numberOrNan(f[6], "tau_px");
  row.n_left = count(f[7], "n_left");
  row.n_right = count(f[8], "n_right");
  row.n_putative = count(f[9], "n_putative");
  row.n_ground_truth = count(f[10], "n_ground_truth");
  row.n_selected = count(f[11], "n_selected");
  row.metrics.n_correct = count(f[12], "n_correct");
  row.metrics.precision = numberOrNan(f[13], "precision");
  row.metrics.recall_paper = numberOrNan(f[14], "recall_paper");
  row.metrics.recall_same_tau = numberOrNan(f[15], "recall_same_tau");
  row.metrics.f_paper = numberOrNan(f[16], "f_paper");
  row.metrics.f_same_tau = numberOrNan(f[17], "f_same_tau");
  row.status = statusFromString(f[18]);
  row.seed = parseInteger(f[19], "seed");
  row.detect_seconds = numberOrNan(f[20], "detect_s");
  row.describe_seconds = numberOrNan(f[21], "describe_s");
  row.match_seconds = numberOrNan(f[22], "match_s");
  row.select_seconds = numberOrNan(f[23], "select_s");
  return row;
}

std::vector<ResultRow> parseRows(const std::string& file, const std::string& text) {
  const auto damaged = [&file](std::size_t row, const std::string& problem) {
    return RunFolderError(file + ", line " + std::to_string(row + 2) + ": " + problem +
                          "; repair or remove the line, or run the benchmark again into another output_dir");
  };
  const std::vector<std::string> lines = completeLines(text);
  if (lines.empty() || lines.front() != kPairsHeader) {
    throw RunFolderError(file +
                         ", line 1: is not the header that this version writes; run the benchmark again "
                         "into another output_dir");
  }
  std::vector<ResultRow> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    try {
      rows.push_back(ResultRow::fromCsv(lines[i]));
    } catch (const std::invalid_argument& problem) {
      throw damaged(i - 1, problem.what());
    }
  }
  const auto key = [&rows](std::size_t i) {
    const ResultRow& row = rows[i];
    // Labelled rows have no tolerance, and NaN has no order.
    const double tau = std::isnan(row.metrics.tau) ? -1 : row.metrics.tau;
    return std::tuple<const std::string&, const std::string&, const std::string&, const std::string&,
                      const std::string&, const std::string&, double, int>(
        row.id.dataset, row.id.sequence, row.id.pair, row.features, row.preselection, row.selector, tau,
        row.seed);
  };
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
  for (std::size_t k = 1; k < order.size(); ++k) {
    if (key(order[k - 1]) == key(order[k])) {
      throw damaged(order[k], "repeats the selection of line " + std::to_string(order[k - 1] + 2));
    }
  }
  return rows;
}

std::vector<ResultRow> readResults(const std::string& folder) {
  const fs::path file = fs::path(folder) / "pairs.csv";
  if (!fs::is_regular_file(file)) {
    throw RunFolderError(file.string() + " does not exist: give the folder of a run, its output_dir");
  }
  const std::string text = readTextFile(file);
  std::vector<ResultRow> rows = parseRows(file.string(), text);
  const auto at = [&file](std::size_t line) {
    return file.string() + ", line " + std::to_string(line) + ": ";
  };
  if (text.back() != '\n') {
    throw RunFolderError(at(rows.size() + 2) +
                         "is cut off; continue the run with resume:=true, or remove the line");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string problem = contradictionIn(rows[i]);
    if (problem.empty()) continue;
    throw RunFolderError(at(i + 2) + problem +
                         "; the line was changed after the run: run the benchmark again into another "
                         "output_dir");
  }
  return rows;
}

std::vector<SummaryRow> summarize(const std::vector<ResultRow>& rows) {
  // One pair's repetitions, averaged.
  struct PairValues {
    std::vector<double> precision, recall_paper, f_paper, recall_same_tau, f_same_tau;
  };
  struct Group {
    SummaryRow row;
    std::vector<PairId> order;
    std::map<PairId, PairValues> pairs;
    std::vector<double> seconds;
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
    const Interval interval = bootstrapMean(f, 0);
    row.f_low = interval.low;
    row.f_high = interval.high;
    row.recall_same_tau = mean(perPair(&PairValues::recall_same_tau));
    row.f_same_tau = mean(perPair(&PairValues::f_same_tau));
    row.select_median = quantile(group.seconds, 0.5);
    row.select_p95 = quantile(group.seconds, 0.95);
    summary.push_back(row);
  }
  return summary;
}

}  // namespace corrsel::core
