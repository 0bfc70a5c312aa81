#include "corrsel/benchmark/results.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <unordered_map>
#include <utility>

#include "base/text.h"
#include "benchmark/files.h"
#include "benchmark/read_pairs.h"
#include "benchmark/tables.h"
#include "corrsel/evaluation/pose.h"

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
                       std::isnan(m.f_same_tau) && std::isnan(row.select_seconds) &&
                       std::isnan(row.confidence);
    return empty ? "" : "status " + toString(row.status) + " beside numbers of a selection";
  }
  if (row.confidence < 0 || std::isinf(row.confidence)) {
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

/// The contradiction in a row of poses.csv; empty for a row as the benchmark writes it.
std::string contradictionIn(const PoseRow& row) {
  const auto outside = [](const char* name, double value, double lowest, double highest) -> std::string {
    if (std::isnan(value) || (value >= lowest && value <= highest)) return "";
    return std::string(name) + " = " + formatNumber(value) + " is outside [" + formatNumber(lowest) + ", " +
           formatNumber(highest) + "]";
  };
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const std::string& problem :
       {outside("rotation_deg", row.rotation_error, 0, 180),
        outside("translation_deg", row.translation_error, 0, 90),
        outside("pose_deg", row.pose_error, 0, kFailedPose),
        outside("epipolar_precision", row.epipolar_precision, 0, 1),
        outside("corner_px", row.corner_error, 0, kInfinite),
        outside("estimate_s", row.seconds, 0, std::numeric_limits<double>::max())}) {
    if (!problem.empty()) return problem;
  }
  const bool estimated = !std::isnan(row.pose_error) || !std::isnan(row.corner_error);
  if (!row.judged()) {
    return estimated || row.n_selected > 0 || !std::isnan(row.seconds)
               ? "status " + toString(row.status) + " beside numbers of a selection"
               : "";
  }
  if (row.n_inliers > row.n_selected) {
    return "n_inliers = " + std::to_string(row.n_inliers) +
           " exceeds n_selected = " + std::to_string(row.n_selected);
  }
  if (std::isnan(row.pose_error)) {
    const bool none = row.model == PoseModel::kNone && row.n_inliers == 0 && std::isnan(row.rotation_error) &&
                      std::isnan(row.translation_error);
    return none ? "" : "numbers of a pose without pose_deg";
  }
  const bool found = row.model != PoseModel::kNone;
  if (found == std::isnan(row.rotation_error)) {
    return "rotation_deg = " + formatNumber(row.rotation_error) + " with model " + toString(row.model);
  }
  // The length of the true translation is not in the file: without an angle, the error is the rotation or
  // 180.
  double pose =
      std::isnan(row.translation_error) && row.pose_error != kFailedPose ? row.rotation_error : kFailedPose;
  if (!std::isnan(row.translation_error)) pose = std::max(row.rotation_error, row.translation_error);
  if (!near(row.pose_error, pose)) {
    return "pose_deg = " + formatNumber(row.pose_error) + " instead of " + formatNumber(pose);
  }
  return "";
}

/// What names the selections of the rows of a table, as numbers: millions of rows would need too much memory
/// for their texts.
class SelectionKeys {
 public:
  /// @param tau  0 in a table without tolerances
  template <class Row>
  void add(const Row& row, double tau) {
    const std::uint32_t pair = numberOf(csvLine({row.id.dataset, row.id.sequence, row.id.pair}));
    const std::uint32_t cell = numberOf(csvLine({row.features, row.preselection, row.selector}));
    // Labelled rows have no tolerance, and NaN has no order.
    keys_.emplace_back(pair, cell, std::isnan(tau) ? -1 : tau, row.seed,
                       static_cast<std::uint32_t>(keys_.size()));
  }

  /// Two rows of one selection, the earlier one first, if there are any.
  std::optional<std::pair<std::size_t, std::size_t>> repetition() {
    std::sort(keys_.begin(), keys_.end());
    const auto same = [](Key a, const Key& b) {
      std::get<4>(a) = std::get<4>(b);
      return a == b;
    };
    const auto found = std::adjacent_find(keys_.begin(), keys_.end(), same);
    if (found == keys_.end()) return std::nullopt;
    return std::pair<std::size_t, std::size_t>(std::get<4>(*found), std::get<4>(*(found + 1)));
  }

 private:
  using Key = std::tuple<std::uint32_t, std::uint32_t, double, int, std::uint32_t>;

  std::uint32_t numberOf(const std::string& text) {
    return numbers_.emplace(text, static_cast<std::uint32_t>(numbers_.size())).first->second;
  }

  std::unordered_map<std::string, std::uint32_t> numbers_;
  std::vector<Key> keys_;
};

double toleranceOf(const ResultRow& row) { return row.metrics.tau; }
double toleranceOf(const PoseRow&) { return 0; }

/// See read_pairs.h.
template <class Row>
bool forEachRow(const CsvTable<Row>& table, const std::string& file,
                const std::function<void(const Row&)>& use) {
  const auto damaged = [&file](std::size_t line, const std::string& problem) {
    return RunFolderError(file + ", line " + std::to_string(line) + ": " + problem +
                          "; repair or remove the line, or run the benchmark again into another folder");
  };
  const auto requireHeader = [&](bool found) {
    if (found) return;
    throw RunFolderError(file +
                         ", line 1: this is not the header that this version writes; run the benchmark "
                         "again into another folder");
  };
  SelectionKeys keys;
  std::size_t line = 0;
  const bool complete = forEachLine(file, [&](const std::string& text) {
    if (++line == 1) return requireHeader(text == table.header());
    try {
      const Row row = table.parse(text);
      keys.add(row, toleranceOf(row));
      use(row);
    } catch (const std::invalid_argument& problem) {
      throw damaged(line, problem.what());
    }
  });
  requireHeader(line > 0);
  if (const auto found = keys.repetition()) {
    throw damaged(found->second + 2, "repeats the selection of line " + std::to_string(found->first + 2));
  }
  return complete;
}

/// The rows of a file of a run that has ended, checked.
template <class Row>
std::vector<Row> readRows(const CsvTable<Row>& table, const fs::path& file) {
  std::vector<Row> rows;
  const auto at = [&file](std::size_t line) {
    return file.string() + ", line " + std::to_string(line) + ": ";
  };
  const bool complete =
      forEachRow<Row>(table, file.string(), [&rows](const Row& row) { rows.push_back(row); });
  if (!complete) {
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

}  // namespace

bool forEachPairRow(const std::string& file, const std::function<void(const ResultRow&)>& use) {
  return forEachRow<ResultRow>(pairsTable(), file, use);
}

bool forEachPoseRow(const std::string& file, const std::function<void(const PoseRow&)>& use) {
  return forEachRow<PoseRow>(posesTable(), file, use);
}

std::vector<ResultRow> readResults(const std::string& folder) {
  const fs::path file = fs::path(folder) / pairsTable().file();
  if (!fs::is_regular_file(file)) {
    throw RunFolderError(file.string() + " does not exist: give the output folder of a run");
  }
  return readRows(pairsTable(), file);
}

std::vector<PoseRow> readPoses(const std::string& folder) {
  const fs::path file = fs::path(folder) / posesTable().file();
  if (!fs::is_regular_file(file)) return {};
  return readRows(posesTable(), file);
}

}  // namespace corrsel::core
