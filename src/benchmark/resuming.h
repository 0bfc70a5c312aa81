#pragma once

#include <cstddef>
#include <set>
#include <string>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/run_folder.h"

namespace corrsel::core {

/// What the folder of a run holds about a finished pair.
struct FinishedPair {
  std::size_t number = 0;  ///< place of the pair in the undivided run, from 0
  std::vector<ResultRow> rows;
  std::vector<StageTime> stages;
  std::vector<TruthCheck> checks;
  std::vector<PoseRow> poses;
  std::vector<SavedSelection> saved;
};

/// The pairs of a run's folder that have all their rows, stages and saved selections, in the order of
/// pairs.csv. Damaged lines of stages.csv are left out, so that their pairs are run again; those of
/// truth_check.csv are left out. Throws RunFolderError naming the file, the line and the remedy where
/// pairs.csv or poses.csv is damaged.
std::vector<FinishedPair> finishedPairs(const std::string& folder, const BenchmarkConfig& config);

/// Removes what belongs to no finished pair from pairs.csv, poses.csv, stages.csv, truth_check.csv,
/// images/index.csv and matches/index.csv; lines that belong to no pair at all stay. @return the finished
/// pairs. Throws RunFolderError like finishedPairs().
std::set<PairId> dropUnfinishedPairs(const std::string& folder, const BenchmarkConfig& config);

/// Throws RunFolderError naming the keys where the folder's configuration differs from `config`.
/// @param remedy  the last sentence of the error
void requireSameConfiguration(const std::string& folder, const BenchmarkConfig& config,
                              const std::string& remedy);

}  // namespace corrsel::core
