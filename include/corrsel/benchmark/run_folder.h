#pragma once

#include <cstddef>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/results.h"
#include "corrsel/evaluation/truth_check.h"
#include "corrsel/image_pair.h"
#include "corrsel/selection.h"

namespace corrsel::core {

/// One row of failures.csv: a pair, or a part of the work on it, that failed.
struct Failure {
  PairId id;
  std::string features, stage, error;
};

/// One row of remarks.csv: something about the input that readers of the results should know.
struct Remark {
  std::string dataset, sequence;  ///< empty: all
  std::string selector;           ///< that could not run there; empty: the remark is on no selector
  std::string text;               ///< a sentence without its full stop

  /// The whole sentence, for messages to people.
  std::string sentence() const;
};

/// One row of matches/index.csv: a selection whose matches were saved.
struct SavedSelection {
  std::string file, putative;  ///< the selected and the putative matches, inside matches/
  PairId id;
  std::string features, preselection, selector;
  int seed = 0;
  Status status = Status::kOk;
  std::size_t n_putative = 0, n_selected = 0;
  std::string model_kind, model;  ///< "homography", "fundamental" or "none"; nine numbers, row by row
  /// Names of the images. '#' and a checksum of the pixels stands for a name that is not known; empty: there
  /// are no images either.
  std::string left_image, right_image;
  std::size_t left_width = 0, left_height = 0, right_width = 0, right_height = 0;  ///< px, 0 = unknown
};

/// Wall time of one stage of the work on a pair: "read", "features", "match", "select", "evaluate", and
/// kPoseStage where the pair has rows in poses.csv.
struct StageTime {
  std::string stage;
  double seconds = kUndefined;
};

inline constexpr char kPoseStage[] = "pose";

/// How far a run has got, or how it ended.
struct RunState {
  std::size_t pairs_done = 0, pairs_total = 0, pairs_failed = 0;
  bool interrupted = false;
  std::string shard;           ///< Shard::text()
  double peak_memory_mib = 0;  ///< of the process that wrote the state
  std::vector<std::pair<std::string, std::string>> left_out_datasets;  ///< name and reason

  bool complete() const { return !interrupted && pairs_failed == 0 && pairs_done == pairs_total; }
};

/// The folder that a run writes: config.yaml, environment.json, pairs.csv, poses.csv, stages.csv,
/// truth_check.csv, scaling.csv, failures.csv, remarks.csv, images/, matches/, summary.csv,
/// pose_summary.csv, summary.json (docs/evaluation.md describes them). Everything that was appended is on
/// disk when the call returns, so that an interrupted run can be resumed.
class RunFolder {
 public:
  /// Creates the folder, or resumes the run that it holds. Pairs that were cut off are dropped then, and
  /// failures are forgotten, since a resumed run tries these pairs again.
  /// @param config  resolved
  /// @param resume  whether the folder may hold a run of this configuration
  /// Throws RunFolderError where the folder is not writable, holds a run although `resume` is false, holds a
  /// run of another configuration (the text names the keys that differ), or holds a damaged file.
  RunFolder(const std::string& path, const BenchmarkConfig& config, bool resume);

  const std::string& path() const { return path_; }
  const std::vector<double>& tolerances() const { return tolerances_; }  ///< of the run, px

  /// Whether the folder holds this pair.
  bool isDone(const PairId& id) const { return done_.count(id) > 0; }

  /// Number of finished pairs, those of earlier sessions included.
  std::size_t doneCount() const { return done_.size(); }

  /// Calls `use` with the rows of pairs.csv, those of earlier sessions first. They are not kept in memory.
  void forEachRow(const std::function<void(const ResultRow&)>& use) const;
  std::vector<PoseRow> readPoses() const;  ///< the rows of poses.csv

  /// Appends a finished pair. @param number  place of the pair in the undivided run, from 0
  void appendPair(const std::vector<ResultRow>& rows, std::size_t number,
                  const std::vector<StageTime>& stages, const std::vector<TruthCheck>& checks = {},
                  const std::vector<PoseRow>& poses = {}, const std::vector<SavedSelection>& saved = {});

  /// The sequences whose ground truth is probably not what it was given as, according to the pairs of all
  /// sessions, see truthWarnings().
  std::vector<TruthWarning> doubtfulTruths() const;

  /// Appends a stage that belongs to no pair: "bag" (of a dataset), "scaling", "pictures", "summary".
  void appendStage(const StageTime& stage, const std::string& dataset = "");

  void appendFailure(const Failure& failure);

  /// Appends a remark unless the folder has it already. Remarks of earlier sessions are kept.
  void appendRemark(const Remark& remark);

 private:
  std::string path_;
  std::vector<double> tolerances_;
  std::set<PairId> done_;
  std::set<std::string> remarks_;  ///< lines of remarks.csv
};

/// Throws RunFolderError where the folder holds no run, or a run of another configuration (the text names the
/// keys that differ).
void requireMergeable(const std::string& folder, const BenchmarkConfig& config);

/// Copies the pairs of the folder `from` that `folder` lacks. @return the number of copied pairs
/// Throws RunFolderError like requireMergeable(), and for a damaged file (the text names the line).
std::size_t mergeRun(RunFolder& folder, const std::string& from, const BenchmarkConfig& config);

/// Sorts pairs.csv, poses.csv and truth_check.csv into the order of the undivided run, whatever the order in
/// which the pairs were finished, and writes summary.csv, pose_summary.csv and summary.json. @return the
/// summary
std::vector<SummaryRow> writeSummary(const RunFolder& folder, const RunState& state);

}  // namespace corrsel::core
