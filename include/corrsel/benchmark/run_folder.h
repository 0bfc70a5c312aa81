#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/results.h"
#include "corrsel/image_pair.h"

namespace corrsel::core {

/// A pair that could not be worked on, or a part of it.
struct Failure {
  PairId id;
  std::string features, stage, error;
};

/// A picture of matches, listed in images/index.csv.
struct ExampleImage {
  std::string file;  ///< inside images/
  PairId id;
  std::string features, preselection, selector;
  std::size_t n_selected = 0, n_correct = 0, n_wrong = 0, n_missed = 0;
  double tau = kUndefined;  ///< px
};

/// Wall time of one stage of the work on a pair: "read", "features", "match", "select", "evaluate".
struct StageTime {
  std::string stage;
  double seconds;
};

/// One timed selection of generated matches.
struct ScalingRow {
  std::string selector;
  int threads = 1;
  std::size_t n = 0;  ///< matches
  int round = 0;
  std::size_t n_selected = 0;
  Status status = Status::kOk;
  double select_seconds = kUndefined;
};

/// A part of a run that is cut to be made on several machines: pairs whose number in the uncut run leaves the
/// remainder `index` on division by `count`. Neighbours go to different parts, which evens out the work.
struct Shard {
  std::size_t index = 0, count = 1;

  bool holds(std::size_t number) const { return number % count == index; }

  /// "1/3" for index 0 of 3; empty where the run is not cut.
  std::string text() const;

  /// Reads "i/n" with 1 <= i <= n <= 100000; empty means uncut. Throws std::invalid_argument.
  static Shard fromText(const std::string& text);
};

struct RunState {
  std::size_t pairs_done = 0, pairs_total = 0, pairs_failed = 0;
  bool interrupted = false;
  std::string shard;           ///< Shard::text()
  double peak_memory_mib = 0;  ///< of the process that wrote the state
  std::vector<std::pair<std::string, std::string>> left_out_datasets;  ///< name and reason

  bool complete() const { return !interrupted && pairs_failed == 0 && pairs_done == pairs_total; }
};

/// The folder that a run leaves behind: config.yaml, environment.json, pairs.csv, stages.csv, scaling.csv,
/// failures.csv, images/, summary.csv, summary.json. What has been appended is on disk when the call returns.
class RunFolder {
 public:
  /// Creates the folder, or takes up the run that it holds. @param config  resolved
  /// Throws RunFolderError: not writable; holds a run and resume is false; holds a run of another
  /// configuration (naming the keys that differ); holds a pairs.csv with another header.
  RunFolder(const std::string& path, const BenchmarkConfig& config, bool resume);

  const std::string& path() const { return path_; }

  /// Whether an earlier session finished this pair.
  bool isDone(const PairId& id) const;

  /// Pairs finished, those of earlier sessions included.
  std::size_t doneCount() const { return done_.size(); }

  /// Reads the rows on disk, those of earlier sessions first: nothing is kept in memory between pairs.
  std::vector<ResultRow> readRows() const;

  /// Throws RunFolderError where the folder holds no run, or one of another configuration (naming the keys
  /// that differ).
  static void requireMergeable(const std::string& folder, const BenchmarkConfig& config);

  /// Takes over the pairs of another folder that this one has not got. @return pairs taken over
  /// Throws RunFolderError like requireMergeable(), and for a damaged file (naming the line).
  std::size_t merge(const std::string& folder, const BenchmarkConfig& config);

  /// @param number  place of the pair in the uncut run, from 0
  void appendPair(const std::vector<ResultRow>& rows, std::size_t number,
                  const std::vector<StageTime>& stages);

  /// A stage that belongs to no pair: "bag" (of a dataset), "scaling", "pictures", "summary".
  void appendStage(const StageTime& stage, const std::string& dataset = "");
  void appendFailure(const Failure& failure);

  bool hasScaling() const;
  void writeScaling(const std::vector<ScalingRow>& rows) const;

  /// Pair and selector of every picture listed.
  std::vector<ExampleImage> readImages() const;

  /// Removes all pictures.
  void clearImages() const;

  /// Writes the picture (8-bit BGR, JPEG) and lists it. `image.file` is filled in.
  void appendImage(ExampleImage image, const cv::Mat& picture);

  /// Puts pairs.csv into the order of the uncut run, whatever came first, and writes summary.csv and
  /// summary.json. @return the summary
  std::vector<SummaryRow> writeSummary(const RunState& state) const;

 private:
  void takeUp(const BenchmarkConfig& config);
  void sortPairs() const;
  void append(const std::string& file, const std::string& text) const;

  std::string path_;
  std::set<PairId> done_;
};

}  // namespace corrsel::core
