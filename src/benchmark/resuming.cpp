#include "benchmark/resuming.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "base/text.h"
#include "benchmark/files.h"
#include "benchmark/read_pairs.h"
#include "benchmark/tables.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

/// Whether a pair has all its rows of pairs.csv, poses.csv and matches/index.csv. Its features (given or not)
/// are those of its rows, and its stages tell whether it has poses.
bool hasAllRows(const BenchmarkConfig& config, const FinishedPair& pair) {
  const bool given = pair.rows.front().features == kGivenFeatures;
  std::size_t selections = 0, cells = 0;
  for (const std::string& features : given ? std::vector<std::string>{kGivenFeatures} : config.features) {
    for (const std::string& preselection : config.preselectionsOf(features)) {
      ++cells;
      for (const std::string& selector : config.selectors) {
        selections += preselection == "nnsr" && isNnsr(selector) ? 0 : 1;
      }
    }
  }
  selections *= static_cast<std::size_t>(config.repetitions);
  const bool with_poses = std::any_of(pair.stages.begin(), pair.stages.end(),
                                      [](const StageTime& stage) { return stage.stage == kPoseStage; });
  // One more of each cell: the pose from the ground-truth inliers.
  const std::size_t poses = with_poses ? selections + cells : 0;
  const std::size_t saved = config.save_matches ? selections : 0;
  return pair.rows.size() == selections && pair.poses.size() == poses && pair.saved.size() == saved;
}

/// Keeps the lines of `pairs`, and those that belong to no pair, in a file that has the columns dataset,
/// sequence and pair side by side.
template <class Row>
void keepPairs(const std::string& folder, const CsvTable<Row>& table, const std::set<PairId>& pairs) {
  const std::string file = (fs::path(folder) / table.file()).string();
  const std::size_t first = table.indexOf("dataset");
  const std::string text = readTextFile(file);
  std::string kept;
  const std::vector<std::string> lines = completeLines(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string> fields = parseCsvLine(lines[i]);
    const bool in_head = i < table.headLines();
    if (!in_head && fields.size() < first + 3) continue;
    const bool of_no_pair = in_head || fields[first + 2].empty();
    if (of_no_pair || pairs.count({fields[first], fields[first + 1], fields[first + 2]})) {
      kept += lines[i] + "\n";
    }
  }
  if (kept.empty()) kept = table.head();
  if (kept != text) writeFile(file, kept);
}

}  // namespace

std::vector<FinishedPair> finishedPairs(const std::string& folder, const BenchmarkConfig& config) {
  const std::string file = (fs::path(folder) / kPairsFile).string();
  const std::vector<std::string> lines = completeLines(readTextFile(file));
  if (lines.empty()) return {};
  const CsvTable<ResultRow> table = pairsTableIn(file);
  std::vector<FinishedPair> pairs;
  std::map<PairId, std::size_t> index;
  for (std::size_t i = table.headLines(); i < lines.size(); ++i) {
    try {
      const ResultRow row = table.parse(lines[i]);
      const auto [found, is_new] = index.emplace(row.id, pairs.size());
      if (is_new) pairs.emplace_back();
      pairs[found->second].rows.push_back(row);
    } catch (const std::invalid_argument& problem) {
      throw RunFolderError(file + ", line " + std::to_string(i + 1) + ": " + problem.what() +
                           "; remove the line or give another output folder");
    }
  }
  const std::string stages = (fs::path(folder) / stagesTable().file()).string();
  for (const StageRow& row : stagesTable().intactRows(readTextFile(stages))) {
    const auto found = index.find(row.id);
    if (found == index.end() || !row.number) continue;
    pairs[found->second].number = *row.number;
    pairs[found->second].stages.push_back(row.stage);
  }
  const std::string checks = (fs::path(folder) / truthChecksTable().file()).string();
  for (const TruthCheck& check : truthChecksTable().intactRows(readTextFile(checks))) {
    const auto found = index.find(check.id);
    if (found != index.end()) pairs[found->second].checks.push_back(check);
  }
  const std::string poses = (fs::path(folder) / posesTable().file()).string();
  if (fs::exists(poses)) {
    forEachPoseRow(poses, [&](const PoseRow& row) {
      const auto found = index.find(row.id);
      if (found != index.end()) pairs[found->second].poses.push_back(row);
    });
  }
  const std::string selections = (fs::path(folder) / savedMatchesTable().file()).string();
  for (const SavedSelection& selection : savedMatchesTable().intactRows(readTextFile(selections))) {
    const auto found = index.find(selection.id);
    if (found != index.end()) pairs[found->second].saved.push_back(selection);
  }
  const auto unfinished = [&config](const FinishedPair& pair) {
    return pair.stages.empty() || !hasAllRows(config, pair);
  };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), unfinished), pairs.end());
  return pairs;
}

std::set<PairId> dropUnfinishedPairs(const std::string& folder, const BenchmarkConfig& config) {
  std::set<PairId> done;
  for (const FinishedPair& pair : finishedPairs(folder, config)) done.insert(pair.rows.front().id);
  keepPairs(folder, pairsTable(config.tolerances), done);
  keepPairs(folder, posesTable(), done);
  keepPairs(folder, stagesTable(), done);
  keepPairs(folder, imagesTable(), done);
  keepPairs(folder, truthChecksTable(), done);
  if (config.save_matches) keepPairs(folder, savedMatchesTable(), done);
  return done;
}

void requireSameConfiguration(const std::string& folder, const BenchmarkConfig& config,
                              const std::string& remedy) {
  std::vector<std::string> differences;
  try {
    differences = yamlDifferences(readTextFile(folder + "/config.yaml"), config.toYaml());
  } catch (const std::invalid_argument& problem) {
    throw RunFolderError(folder + "/config.yaml is damaged (" + problem.what() + "); " + remedy);
  }
  if (differences.empty()) return;
  throw RunFolderError("the folder " + folder + " holds a run of another configuration; it differs in:\n  " +
                       joinList(differences, "\n  ") + "\n" + remedy);
}

}  // namespace corrsel::core
