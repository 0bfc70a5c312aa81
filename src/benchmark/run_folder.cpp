#include "corrsel/benchmark/run_folder.h"

#include <filesystem>

#include "base/text.h"
#include "benchmark/environment.h"
#include "benchmark/files.h"
#include "benchmark/read_pairs.h"
#include "benchmark/resuming.h"
#include "benchmark/tables.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

template <class Row>
std::string pathOf(const CsvTable<Row>& table, const std::string& folder) {
  return (fs::path(folder) / table.file()).string();
}

template <class Row>
void writeEmpty(const CsvTable<Row>& table, const std::string& folder) {
  writeFile(pathOf(table, folder), table.head());
}

}  // namespace

RunFolder::RunFolder(const std::string& path, const BenchmarkConfig& config, bool resume)
    : path_(path), tolerances_(config.tolerances) {
  std::error_code error;
  fs::create_directories(fs::path(path) / "images", error);
  if (config.save_matches && !error) {
    fs::create_directories(fs::path(pathOf(savedMatchesTable(), path)).parent_path(), error);
  }
  if (error) {
    throw RunFolderError("cannot create the output folder " + path + ": " + error.message() +
                         "; give another output folder or change its permissions");
  }
  if (fs::exists(fs::path(path) / "config.yaml")) {
    requireSameConfiguration(path, config,
                             "give another output folder, or the arguments that this run was started with");
    if (!resume) {
      throw RunFolderError("the output folder " + path +
                           " already holds a run of this configuration; resume the run, or give another "
                           "output folder");
    }
    if (!fs::exists(pathOf(posesTable(), path))) writeEmpty(posesTable(), path);  // an older version's run
    done_ = dropUnfinishedPairs(path, config);
  } else if (const std::string pairs = pathOf(pairsTable(tolerances_), path);
             fs::exists(pairs) && readTextFile(pairs) != pairsTable(tolerances_).head()) {
    throw RunFolderError("the output folder " + path +
                         " holds a pairs.csv without its config.yaml; give another output folder");
  } else {
    writeEmpty(pairsTable(tolerances_), path);
    writeEmpty(posesTable(), path);
    writeEmpty(stagesTable(), path);
    writeEmpty(imagesTable(), path);
    writeEmpty(truthChecksTable(), path);
    if (config.save_matches) writeEmpty(savedMatchesTable(), path);
    writeFile((fs::path(path) / "config.yaml").string(), config.toYaml());
  }
  if (fs::exists(pathOf(remarksTable(), path))) {
    for (const Remark& remark : readRemarks(path)) remarks_.insert(remarksTable().line(remark));
  } else {
    writeEmpty(remarksTable(), path);
  }
  // Every session tries the failed pairs again.
  writeEmpty(failuresTable(), path);
  writeEnvironment(path, config.threads);
}

void RunFolder::forEachRow(const std::function<void(const ResultRow&)>& use) const {
  forEachPairRow((fs::path(path_) / kPairsFile).string(), use);
}

std::vector<PoseRow> RunFolder::readPoses() const {
  std::vector<PoseRow> rows;
  forEachPoseRow(pathOf(posesTable(), path_), [&rows](const PoseRow& row) { rows.push_back(row); });
  return rows;
}

void RunFolder::appendPair(const std::vector<ResultRow>& rows, std::size_t number,
                           const std::vector<StageTime>& stages, const std::vector<TruthCheck>& checks,
                           const std::vector<PoseRow>& poses, const std::vector<SavedSelection>& saved) {
  if (rows.empty()) return;
  const PairId& id = rows.front().id;
  std::string text;
  for (const StageTime& stage : stages) text += stagesTable().line({number, id, stage});
  appendToFile(pathOf(stagesTable(), path_), text);
  text.clear();
  for (const TruthCheck& check : checks) text += truthChecksTable().line(check);
  appendToFile(pathOf(truthChecksTable(), path_), text);
  if (!saved.empty()) {
    text.clear();
    for (const SavedSelection& selection : saved) text += savedMatchesTable().line(selection);
    appendToFile(pathOf(savedMatchesTable(), path_), text);
  }
  text.clear();
  for (const PoseRow& row : poses) text += posesTable().line(row);
  appendToFile(pathOf(posesTable(), path_), text);
  text.clear();
  const CsvTable<ResultRow> pairs = pairsTable(tolerances_);
  for (const ResultRow& row : rows) text += pairs.line(row);
  appendToFile(pathOf(pairs, path_), text);
  done_.insert(id);
}

std::vector<TruthWarning> RunFolder::doubtfulTruths() const {
  return truthWarnings(truthChecksTable().intactRows(readTextFile(pathOf(truthChecksTable(), path_))));
}

void RunFolder::appendStage(const StageTime& stage, const std::string& dataset) {
  appendToFile(pathOf(stagesTable(), path_), stagesTable().line({std::nullopt, {dataset, "", ""}, stage}));
}

void RunFolder::appendFailure(const Failure& failure) {
  appendToFile(pathOf(failuresTable(), path_), failuresTable().line(failure));
}

void RunFolder::appendRemark(const Remark& remark) {
  const std::string line = remarksTable().line(remark);
  if (remarks_.insert(line).second) appendToFile(pathOf(remarksTable(), path_), line);
}

std::string Remark::sentence() const {
  const std::string place = sequence.empty() ? dataset : dataset + "/" + sequence;
  if (selector.empty()) return (place.empty() ? "" : place + ": ") + text;
  return selector + " does not run" + (place.empty() ? "" : " on " + place) + ": " + text;
}

}  // namespace corrsel::core
