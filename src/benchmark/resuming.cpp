#include "benchmark/resuming.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <stdexcept>

#include "base/text.h"
#include "benchmark/files.h"
#include "benchmark/tables.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

/// Number of rows of a pair whose truth (labelled or not) and features (given or not) are those of `rows`.
std::size_t expectedRows(const BenchmarkConfig& config, const std::vector<ResultRow>& rows) {
  const bool given = rows.front().features == kGivenFeatures;
  std::size_t selections = 0;
  for (const std::string& features : given ? std::vector<std::string>{kGivenFeatures} : config.features) {
    for (const std::string& preselection : config.preselectionsOf(features)) {
      for (const std::string& selector : config.selectors) {
        selections += preselection == "nnsr" && isNnsr(selector) ? 0 : 1;
      }
    }
  }
  const std::size_t taus = std::isnan(rows.front().metrics.tau) ? 1 : config.tolerances.size();
  return selections * taus * static_cast<std::size_t>(config.repetitions);
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
    if (i > 0 && fields.size() < first + 3) continue;
    const bool of_no_pair = i == 0 || fields[first + 2].empty();
    if (of_no_pair || pairs.count({fields[first], fields[first + 1], fields[first + 2]})) {
      kept += lines[i] + "\n";
    }
  }
  if (kept.empty()) kept = table.text({});
  if (kept != text) writeFile(file, kept);
}

}  // namespace

std::vector<FinishedPair> finishedPairs(const std::string& folder, const BenchmarkConfig& config) {
  const std::string file = (fs::path(folder) / pairsTable().file()).string();
  const std::vector<std::string> lines = completeLines(readTextFile(file));
  if (!lines.empty() && lines.front() != pairsTable().header()) {
    throw RunFolderError(file + " has another header than this version writes; give another output folder");
  }
  std::vector<FinishedPair> pairs;
  std::map<PairId, std::size_t> index;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    try {
      const ResultRow row = pairsTable().parse(lines[i]);
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
  const auto unfinished = [&config](const FinishedPair& pair) {
    return pair.stages.empty() || pair.rows.size() != expectedRows(config, pair.rows);
  };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), unfinished), pairs.end());
  return pairs;
}

std::set<PairId> dropUnfinishedPairs(const std::string& folder, const BenchmarkConfig& config) {
  std::set<PairId> done;
  for (const FinishedPair& pair : finishedPairs(folder, config)) done.insert(pair.rows.front().id);
  keepPairs(folder, pairsTable(), done);
  keepPairs(folder, stagesTable(), done);
  keepPairs(folder, imagesTable(), done);
  keepPairs(folder, truthChecksTable(), done);
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
