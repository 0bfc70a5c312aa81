#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

#include "corrsel/evaluation/metrics.h"
#include "corrsel/image_pair.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// The folder of a run cannot be used. The text names the file (and the line), the reason and the remedy.
class RunFolderError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// One row of pairs.csv: one selection evaluated at one tolerance. An undefined number is NaN here and empty
/// in the file.
struct ResultRow {
  PairId id;
  std::string features, preselection, selector;
  std::size_t n_left = 0, n_right = 0;
  std::size_t n_putative = 0, n_ground_truth = 0, n_selected = 0;
  Metrics metrics;
  Status status = Status::kOk;
  double confidence = 0.0;  ///< Selection::confidence
  int seed = 0;
  double detect_seconds = kUndefined, describe_seconds = kUndefined, match_seconds = kUndefined;
  double select_seconds = kUndefined;

  /// Returns whether the selector returned a selection that can be evaluated.
  bool judged() const { return status != Status::kUnsupportedInput && status != Status::kFailed; }
};

/// One row of summary.csv: means over pairs of the per-pair values.
struct SummaryRow {
  std::string dataset, features, preselection, selector;
  double tau = kUndefined;  ///< px; NaN for labelled truth
  std::size_t pairs = 0;    ///< pairs in the means: judged pairs that have a ground-truth inlier
  double precision = kUndefined, recall_paper = kUndefined, f_paper = kUndefined;
  double f_low = kUndefined, f_high = kUndefined;  ///< 95 % interval of the mean F, see bootstrapMean()
  double recall_same_tau = kUndefined, f_same_tau = kUndefined;
  double confidence_median = kUndefined;
  double select_median = kUndefined, select_p95 = kUndefined;  ///< s
};

/// Reads the rows of a run folder that is not being written to. Every row is checked: it is complete and
/// appears once, its numbers are in their ranges, and precision, recall and F agree with its counts (to
/// 1e-6). Throws RunFolderError naming the file, the line, the fault and the remedy. O(rows log rows).
std::vector<ResultRow> readResults(const std::string& folder);

/// Groups rows by dataset, features, preselection, selector and tolerance, in the order of first appearance.
/// The repetitions of a pair are averaged before the mean over pairs. O(rows log rows + groups * 2000 *
/// pairs).
std::vector<SummaryRow> summarize(const std::vector<ResultRow>& rows);

}  // namespace corrsel::core
