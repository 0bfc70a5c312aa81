#include "corrsel/benchmark/results.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <tuple>

#include "base/text.h"
#include "benchmark/read_pairs.h"
#include "benchmark/tables.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

bool near(double a, double b) { return std::isnan(a) ? std::isnan(b) : std::abs(a - b) <= 1e-6; }

/// Harmonic mean of correct / selected and correct / inliers; NaN where there is no inlier.
double fOfCounts(double correct, double selected, double inliers) {
  return inliers > 0 ? 2 * correct / (selected + inliers) : kUndefined;
}

/// The contradiction in a row; empty for a row as the benchmark writes it.
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
                       std::isnan(m.f_same_tau) && std::isnan(row.select_seconds) && row.confidence == 0;
    return empty ? "" : "status " + toString(row.status) + " beside numbers of a selection";
  }
  if (!(row.confidence >= 0) || std::isinf(row.confidence)) {
    return "confidence = " + formatNumber(row.confidence) + " is no number from 0";
  }
  if (row.n_selected > row.n_putative) {
    return exceeds("n_selected", row.n_selected, "n_putative", row.n_putative);
  }
  if (m.n_correct > row.n_selected) {
    return exceeds("n_correct", m.n_correct, "n_selected", row.n_selected);
  }
  // The ground truth of this pair is unknown.
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

std::vector<ResultRow> parsePairs(const std::string& file, const std::string& text) {
  const auto damaged = [&file](std::size_t row, const std::string& problem) {
    return RunFolderError(file + ", line " + std::to_string(row + 2) + ": " + problem +
                          "; repair or remove the line, or run the benchmark again into another folder");
  };
  const std::vector<std::string> lines = completeLines(text);
  if (lines.empty() || lines.front() != pairsTable().header()) {
    throw RunFolderError(file +
                         ", line 1: this is not the header that this version writes; run the benchmark "
                         "again into another folder");
  }
  std::vector<ResultRow> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    try {
      rows.push_back(pairsTable().parse(lines[i]));
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
    throw RunFolderError(file.string() + " does not exist: give the output folder of a run");
  }
  const std::string text = readTextFile(file);
  std::vector<ResultRow> rows = parsePairs(file.string(), text);
  const auto at = [&file](std::size_t line) {
    return file.string() + ", line " + std::to_string(line) + ": ";
  };
  if (text.back() != '\n') {
    throw RunFolderError(at(rows.size() + 2) + "the line is cut off; resume the run, or remove the line");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string problem = contradictionIn(rows[i]);
    if (problem.empty()) continue;
    throw RunFolderError(at(i + 2) + problem +
                         "; the line was changed after the run: run the benchmark again into another "
                         "folder");
  }
  return rows;
}

}  // namespace corrsel::core
