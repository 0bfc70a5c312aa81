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

/// "a = 3 exceeds b = 2", or nothing where it does not.
std::string excess(const std::string& part, std::size_t a, const std::string& whole, std::size_t b) {
  if (a <= b) return "";
  return part + " = " + std::to_string(a) + " exceeds " + whole + " = " + std::to_string(b);
}

/// The contradiction in the counts at one tolerance, or with labels.
std::string contradictionIn(const Metrics& metrics, const ResultRow& row) {
  const std::string of = std::isnan(metrics.tau) ? "_labels" : "_" + formatNumber(metrics.tau) + "px";
  const std::string n_correct = "n_correct" + of;
  if (!row.evaluated()) {
    return metrics.n_correct == 0 && std::isnan(metrics.f_paper)
               ? ""
               : "status " + toString(row.status) + " beside " + n_correct;
  }
  if (row.truth != TruthKind::kNone && row.n_ground_truth > 0 && std::isnan(metrics.f_paper)) {
    return n_correct + " is missing";
  }
  for (const std::string& problem :
       {excess("n_inliers" + of, metrics.n_inliers, "n_putative", row.n_putative),
        excess(n_correct, metrics.n_correct, "n_selected", row.n_selected),
        excess(n_correct, metrics.n_correct, "n_inliers" + of, metrics.n_inliers)}) {
    if (!problem.empty()) return problem;
  }
  return "";
}

/// The contradiction in a row; empty for a row as the benchmark writes it.
std::string contradictionIn(const ResultRow& row) {
  for (const auto& [name, seconds] : {std::pair{"detect_s", row.detect_seconds},
                                      {"describe_s", row.describe_seconds},
                                      {"match_s", row.match_seconds},
                                      {"select_s", row.select_seconds}}) {
    if (seconds < 0 || std::isinf(seconds)) {
      return std::string(name) + " = " + formatNumber(seconds) + " is no time";
    }
  }
  for (const std::string& problem :
       {excess("n_ground_truth", row.n_ground_truth, "n_putative", row.n_putative),
        excess("n_selected", row.n_selected, "n_putative", row.n_putative)}) {
    if (!problem.empty()) return problem;
  }
  for (const Metrics& metrics : row.metrics) {
    const std::string problem = contradictionIn(metrics, row);
    if (!problem.empty()) return problem;
  }
  if (!row.evaluated()) {
    const bool empty = row.n_selected == 0 && std::isnan(row.select_seconds) && std::isnan(row.confidence);
    return empty ? "" : "status " + toString(row.status) + " beside numbers of a selection";
  }
  if (row.confidence < 0 || std::isinf(row.confidence)) {
    return "confidence = " + formatNumber(row.confidence) + " is no number from 0";
  }
  return "";
}

std::string outside(const char* name, double value, double lowest, double highest) {
  if (std::isnan(value) || (value >= lowest && value <= highest)) return "";
  return std::string(name) + " = " + formatNumber(value) + " is outside [" + formatNumber(lowest) + ", " +
         formatNumber(highest) + "]";
}

std::string contradictionIn(const OwnPose& own) {
  for (const std::string& problem :
       {outside("own_rotation_deg", own.rotation_error, 0, 180),
        outside("own_translation_deg", own.translation_error, 0, 90),
        outside("own_pose_deg", own.pose_error, 0, kFailedPose),
        outside("second_pose_deg", own.second_error, 0, kFailedPose),
        outside("nees", own.normalized.squared, 0, std::numeric_limits<double>::max())}) {
    if (!problem.empty()) return problem;
  }
  if ((own.motion == Motion::kNone) != std::isnan(own.rotation_error)) {
    return "own_rotation_deg = " + formatNumber(own.rotation_error) + " with motion " + toString(own.motion);
  }
  const std::size_t degrees = own.normalized.degrees;
  const bool has_error = !std::isnan(own.normalized.squared);
  if (has_error ? degrees != 3 && degrees != 5 : degrees != 0) {
    return "nees = " + formatNumber(own.normalized.squared) +
           " with nees_degrees = " + std::to_string(degrees);
  }
  return "";
}

/// The contradiction in a row of poses.csv; empty for a row as the benchmark writes it.
std::string contradictionIn(const PoseRow& row) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  for (const std::string& problem :
       {outside("rotation_deg", row.rotation_error, 0, 180),
        outside("translation_deg", row.translation_error, 0, 90),
        outside("pose_deg", row.pose_error, 0, kFailedPose),
        outside("epipolar_precision", row.epipolar_precision, 0, 1),
        outside("corner_px", row.corner_error, 0, kInfinite),
        outside("estimate_s", row.seconds, 0, std::numeric_limits<double>::max()),
        row.own ? contradictionIn(*row.own) : ""}) {
    if (!problem.empty()) return problem;
  }
  const bool estimated = !std::isnan(row.pose_error) || !std::isnan(row.corner_error);
  if (!row.evaluated()) {
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
  template <class Row>
  void add(const Row& row) {
    const std::uint32_t pair = numberOf(csvLine({row.id.dataset, row.id.sequence, row.id.pair}));
    const std::uint32_t cell = numberOf(csvLine({row.features, row.preselection, row.selector}));
    keys_.emplace_back(pair, cell, row.seed, static_cast<std::uint32_t>(keys_.size()));
  }

  /// Two rows of one selection, the earlier one first, if there are any.
  std::optional<std::pair<std::size_t, std::size_t>> repetition() {
    std::sort(keys_.begin(), keys_.end());
    const auto same = [](Key a, const Key& b) {
      std::get<3>(a) = std::get<3>(b);
      return a == b;
    };
    const auto found = std::adjacent_find(keys_.begin(), keys_.end(), same);
    if (found == keys_.end()) return std::nullopt;
    return std::pair<std::size_t, std::size_t>(std::get<3>(*found), std::get<3>(*(found + 1)));
  }

 private:
  using Key = std::tuple<std::uint32_t, std::uint32_t, int, std::uint32_t>;

  std::uint32_t numberOf(const std::string& text) {
    return numbers_.emplace(text, static_cast<std::uint32_t>(numbers_.size())).first->second;
  }

  std::unordered_map<std::string, std::uint32_t> numbers_;
  std::vector<Key> keys_;
};

/// See read_pairs.h.
template <class Row>
bool forEachRow(const CsvTable<Row>& table, const std::string& file,
                const std::function<void(const Row&)>& use) {
  const auto damaged = [&file](std::size_t line, const std::string& problem) {
    return RunFolderError(file + ", line " + std::to_string(line) + ": " + problem +
                          "; repair or remove the line, or run the benchmark again into another folder");
  };
  SelectionKeys keys;
  std::size_t line = 0;
  std::string head;
  const auto requireHead = [&] {
    if (head == table.head()) return;
    throw RunFolderError(file + ", line " + std::to_string(table.headLines()) +
                         ": this is not the header that this version writes; run the benchmark again into "
                         "another folder");
  };
  const bool complete = forEachLine(file, [&](const std::string& text) {
    if (++line <= table.headLines()) {
      head += text + "\n";
      return;
    }
    if (line == table.headLines() + 1) requireHead();
    try {
      const Row row = table.parse(text);
      keys.add(row);
      use(row);
    } catch (const std::invalid_argument& problem) {
      throw damaged(line, problem.what());
    }
  });
  requireHead();
  if (const auto found = keys.repetition()) {
    const std::size_t first = table.headLines() + 1;
    throw damaged(found->second + first,
                  "repeats the selection of line " + std::to_string(found->first + first));
  }
  return complete;
}

/// The rows of a file of a run that has ended, checked.
template <class Row>
std::vector<Row> readRows(const CsvTable<Row>& table, const fs::path& file) {
  std::vector<Row> rows;
  const std::size_t first = table.headLines() + 1;
  const auto at = [&file](std::size_t line) {
    return file.string() + ", line " + std::to_string(line) + ": ";
  };
  const bool complete =
      forEachRow<Row>(table, file.string(), [&rows](const Row& row) { rows.push_back(row); });
  if (!complete) {
    throw RunFolderError(at(rows.size() + first) + "the line is cut off; resume the run, or remove the line");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string problem = contradictionIn(rows[i]);
    if (problem.empty()) continue;
    throw RunFolderError(at(i + first) + problem +
                         "; the line was changed after the run: run the benchmark again into another "
                         "folder");
  }
  return rows;
}

}  // namespace

const Metrics* ResultRow::metricsAt(double tau) const {
  const auto found = std::find_if(metrics.begin(), metrics.end(),
                                  [tau](const Metrics& at) { return std::isnan(at.tau) || at.tau == tau; });
  return found == metrics.end() ? nullptr : &*found;
}

bool forEachPairRow(const std::string& file, const std::function<void(const ResultRow&)>& use) {
  return forEachRow<ResultRow>(pairsTableIn(file), file, use);
}

bool forEachPoseRow(const std::string& file, const std::function<void(const PoseRow&)>& use) {
  return forEachRow<PoseRow>(posesTable(), file, use);
}

std::vector<ResultRow> readResults(const std::string& folder) {
  const fs::path file = fs::path(folder) / kPairsFile;
  if (!fs::is_regular_file(file)) {
    throw RunFolderError(file.string() + " does not exist: give the output folder of a run");
  }
  return readRows(pairsTableIn(file.string()), file);
}

std::vector<PoseRow> readPoses(const std::string& folder) {
  const fs::path file = fs::path(folder) / posesTable().file();
  if (!fs::is_regular_file(file)) return {};
  return readRows(posesTable(), file);
}

}  // namespace corrsel::core
