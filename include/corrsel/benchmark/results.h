#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/evaluation/metrics.h"
#include "corrsel/image_pair.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// A run's folder cannot be used; the text says why and what to do.
class RunFolderError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One row of pairs.csv: one selection judged at one tolerance. Undefined numbers are NaN here, empty in the
/// file.
struct ResultRow {
  PairId id;
  std::string features, preselection, selector;
  std::size_t n_left = 0, n_right = 0;
  std::size_t n_putative = 0, n_ground_truth = 0, n_selected = 0;
  Metrics metrics;
  Status status = Status::kOk;
  int seed = 0;
  double detect_seconds = kUndefined, describe_seconds = kUndefined, match_seconds = kUndefined;
  double select_seconds = kUndefined;

  /// Whether the selector gave an answer that can be judged.
  bool judged() const { return status != Status::kUnsupportedInput && status != Status::kFailed; }

  std::string toCsv() const;

  /// Throws std::invalid_argument where the line is no complete row.
  static ResultRow fromCsv(const std::string& line);
};

/// One row of summary.csv: means over pairs of the per-pair values.
struct SummaryRow {
  std::string dataset, features, preselection, selector;
  double tau = kUndefined;
  std::size_t pairs = 0;  ///< pairs in the means: judged ones that have a ground-truth inlier
  double precision = kUndefined, recall_paper = kUndefined, f_paper = kUndefined;
  double f_low = kUndefined, f_high = kUndefined;  ///< bootstrap 95 % interval of the mean F
  double recall_same_tau = kUndefined, f_same_tau = kUndefined;
  double select_median = kUndefined, select_p95 = kUndefined;  ///< s
};

/// The first line of pairs.csv.
const char* pairsHeader();

/// The rows of a pairs.csv; row i stands in line i + 2. A last line that was cut off is left out.
/// Throws RunFolderError naming `file` and the line: another header, a line that is no row or is there twice.
std::vector<ResultRow> parseRows(const std::string& file, const std::string& text);

/// Rows of a run folder that is not being written to, each checked: complete, not there twice, numbers in
/// their ranges, and precision, recall and F as the counts give them (to 1e-6).
/// Throws RunFolderError naming file, line, what is wrong and what to do. O(rows log rows).
std::vector<ResultRow> readResults(const std::string& folder);

/// Groups rows by dataset, features, preselection, selector and tolerance, in order of first appearance.
/// Repetitions of a pair are averaged before the mean over pairs. O(rows log rows + groups * 2000 * pairs).
std::vector<SummaryRow> summarize(const std::vector<ResultRow>& rows);

}  // namespace corrsel::core
