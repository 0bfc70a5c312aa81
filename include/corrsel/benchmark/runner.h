#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/datasets/pair_source.h"
#include "corrsel/progress.h"
#include "corrsel/selectors/selector.h"
#include "corrsel/shard.h"

namespace corrsel::core {

/// Is called on the thread of the run whenever something happens.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  virtual void progress(const Progress&) {}
  virtual void evaluated(const ResultRow&) {}  ///< one selection evaluated
  virtual void failed(const Failure&) {}
  /// After the last pair of a sequence whose ground truth is probably not what it was given as, and after the
  /// eighth of a longer one. The counts are those of this session's pairs so far.
  virtual void doubtful(const TruthWarning&) {}
  /// Something about the input, once per run.
  virtual void noticed(const Remark&) {}
};

/// Runs the grid of cells (features, preselection) x selectors over sources of image pairs, pair by pair, and
/// writes the run's folder. One pair is in memory at a time.
class BenchmarkRunner {
 public:
  /// @param config  resolved
  /// @param stop    may be set by another thread or a signal handler; the run ends after the current
  /// selection
  BenchmarkRunner(const BenchmarkConfig& config, RunFolder& folder, RunObserver& observer,
                  const std::atomic<bool>& stop);
  ~BenchmarkRunner();

  /// Runs all pairs of the shard that the folder does not hold yet. A failure is recorded, and the run goes
  /// on with the next pair. Throws RunFolderError where results cannot be written.
  RunState run(const std::vector<std::unique_ptr<PairSource>>& sources, const Shard& shard = {});

  /// Measures selection times against the number of matches and writes scaling.csv, where the configuration
  /// asks for it (BenchmarkConfig::measuresScaling()) and the folder has none yet.
  void timeSelectors();

  /// Draws what every selector keeps on example pairs, which are chosen from the folder's rows so that every
  /// selector is shown at a success and at a failure. The pictures are drawn with the features and the
  /// preselection of the first cell. Nothing is done where these pictures exist already, and nothing where
  /// the experiment makes variants of the selectors.
  /// @param sources  those of run(), opened again
  void drawExamples(const std::vector<std::unique_ptr<PairSource>>& sources);

 private:
  struct Tools;
  struct Putative;
  struct PairRun;
  template <class Use>
  std::size_t eachPair(const std::vector<std::unique_ptr<PairSource>>& sources, const Use& use);
  Putative putativeMatches(const ImagePair& pair, const std::string& features) const;
  const Selector& selectorFor(const ImagePair& pair, std::size_t selector, int repetition) const;
  ResultRow resultRow(const ImagePair& pair, const Putative& putative, const Cell& cell,
                      const std::string& selector, int repetition, const Selection& selection) const;
  PoseRow poseRow(const ImagePair& pair, const Putative& putative, const Cell& cell,
                  const std::string& selector, int repetition, const Selection& selection) const;
  PoseRow groundTruthPose(const ImagePair& pair, const Putative& putative, const Cell& cell) const;
  void drawExample(const ImagePair& pair, const Putative& putative, const Cell& cell,
                   const std::string& selector, const Selection& selection);
  bool runCell(const Cell& cell, const Putative& input, PairRun& run);
  void runPair(const ImagePair& pair, std::size_t number, double read_seconds);
  void warmUp() const;
  void notice(const Remark& remark);
  void noticeImages(const ImagePair& pair);
  void recordFailure(const PairId& id, const char* stage, const std::string& error);
  void reportTruth(const PairId& next);

  const BenchmarkConfig& config_;
  RunFolder& folder_;
  RunObserver& observer_;
  const std::atomic<bool>& stop_;
  std::unique_ptr<Tools> tools_;
  std::vector<TruthCheck> sequence_checks_;  ///< of the sequence that is being run
  std::size_t sequence_pairs_ = 0;
};

}  // namespace corrsel::core
