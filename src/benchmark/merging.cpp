#include <filesystem>

#include "benchmark/environment.h"
#include "benchmark/resuming.h"
#include "benchmark/saved_matches.h"
#include "benchmark/tables.h"

namespace corrsel::core {

namespace fs = std::filesystem;

void requireMergeable(const std::string& folder, const BenchmarkConfig& config) {
  if (!fs::exists(fs::path(folder) / "config.yaml") || !fs::exists(fs::path(folder) / kPairsFile)) {
    throw RunFolderError("cannot merge " + folder +
                         ": it holds no run (no config.yaml and pairs.csv); name folders of runs");
  }
  requireSameConfiguration(folder, config,
                           "merge only runs that were given the same arguments, except for shard");
}

std::size_t mergeRun(RunFolder& folder, const std::string& from, const BenchmarkConfig& config) {
  requireMergeable(from, config);
  std::size_t copied = 0;
  for (const FinishedPair& pair : finishedPairs(from, config)) {
    if (folder.isDone(pair.rows.front().id)) continue;
    copySavedMatches(from, folder.path(), pair.saved);
    folder.appendPair(pair.rows, pair.number, pair.stages, pair.checks, pair.poses, pair.saved);
    ++copied;
  }
  for (const Remark& remark : readRemarks(from)) folder.appendRemark(remark);
  addMergedEnvironment(folder.path(), from, copied);
  return copied;
}

}  // namespace corrsel::core
