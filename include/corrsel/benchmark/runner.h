#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/progress.h"
#include "corrsel/benchmark/results.h"
#include "corrsel/datasets/pair_source.h"

namespace corrsel::core {

/// Told what happens during a run, on the thread of the run.
class RunObserver {
 public:
  virtual ~RunObserver() = default;
  virtual void progress(const Progress&) {}
  /// One selection judged: its rows, one per tolerance.
  virtual void judged(const std::vector<ResultRow>&) {}
  virtual void failed(const Failure&) {}
};

/// Runs the grid features x preselection x selector over sources of image pairs, pair by pair, and writes the
/// run's folder. One pair is in memory at a time.
class BenchmarkRunner {
 public:
  /// @param config  resolved
  /// @param stop    set by another thread or a signal handler: the run ends after the selection it is at
  BenchmarkRunner(const BenchmarkConfig& config, RunFolder& folder, RunObserver& observer,
                  const std::atomic<bool>& stop);
  ~BenchmarkRunner();

  /// Runs all pairs that the folder does not hold yet. A pair that fails is recorded and the run goes on.
  /// Throws RunFolderError where results cannot be written.
  RunState run(const std::vector<std::unique_ptr<PairSource>>& sources);

 private:
  struct Tools;
  struct Putative;
  struct Cell;
  std::vector<Putative> putativeMatches(const ImagePair& pair) const;
  std::vector<ResultRow> judge(const ImagePair& pair, const Putative& putative, const Cell& cell,
                               const Selection& selection) const;
  void drawExample(const ImagePair& pair, const Putative& putative, const Cell& cell,
                   const Selection& selection) const;
  void runPair(const ImagePair& pair, bool example);
  void warmUp() const;

  const BenchmarkConfig& config_;
  RunFolder& folder_;
  RunObserver& observer_;
  const std::atomic<bool>& stop_;
  std::unique_ptr<Tools> tools_;
};

}  // namespace corrsel::core
