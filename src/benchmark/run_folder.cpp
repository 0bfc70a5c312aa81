#include "corrsel/benchmark/run_folder.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "base/text.h"
#include "benchmark/environment.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSummaryHeader =
    "dataset,features,preselection,selector,tau_px,pairs,precision,recall_paper,f_paper,f_paper_lo,f_paper_"
    "hi,"
    "recall_same_tau,f_same_tau,select_s_median,select_s_p95";
constexpr const char* kStagesHeader = "number,dataset,sequence,pair,stage,seconds";
constexpr const char* kScalingHeader = "selector,threads,n,round,n_selected,status,select_s";
constexpr const char* kFailuresHeader = "dataset,sequence,pair,features,stage,error";
constexpr const char* kImagesHeader =
    "file,dataset,sequence,pair,features,preselection,selector,n_selected,n_correct,n_wrong,n_missed,tau_px";

/// Writes through a second file, so that a reader never sees half of it.
void writeFile(const fs::path& file, const std::string& text) {
  const fs::path part = file.string() + ".part";
  std::ofstream out(part, std::ios::binary | std::ios::trunc);
  out << text;
  out.close();
  std::error_code error;
  if (out) fs::rename(part, file, error);
  if (!out || error) {
    throw RunFolderError("cannot write " + file.string() +
                         ": check permissions and free space of the folder");
  }
}

/// Keeps the lines of a listing whose pair (three columns from `first_column`) is in `pairs`, or which are of
/// no pair.
std::string keepPairs(const std::string& text, std::size_t first_column, const std::set<PairId>& pairs) {
  std::string kept;
  const std::vector<std::string> lines = completeLines(text);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::vector<std::string> fields = parseCsvLine(lines[i]);
    if (i > 0 && fields.size() < first_column + 3) continue;
    const bool of_no_pair = i == 0 || fields[first_column + 2].empty();
    if (of_no_pair ||
        pairs.count({fields[first_column], fields[first_column + 1], fields[first_column + 2]})) {
      kept += lines[i] + "\n";
    }
  }
  return kept;
}

/// Rows that a pair must have, given that it is labelled (or has given matches) or not.
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

std::string stageLine(const std::string& number, const PairId& id, const StageTime& stage) {
  return csvLine({number, id.dataset, id.sequence, id.pair, stage.stage, formatNumber(stage.seconds)}) + "\n";
}

/// One row of stages.csv.
struct StageRow {
  std::size_t number = 0;
  PairId id;
  StageTime stage;
};

/// The rows of pairs; lines that are damaged are left out, which makes their pairs be run again.
std::vector<StageRow> readStages(const fs::path& file) {
  std::vector<StageRow> rows;
  const std::vector<std::string> lines = completeLines(readTextFile(file));
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> f = parseCsvLine(lines[i]);
    if (f.size() != 6 || f[0].empty()) continue;
    try {
      const int number = parseInteger(f[0], "number");
      if (number < 0) continue;
      rows.push_back(
          {static_cast<std::size_t>(number), {f[1], f[2], f[3]}, {f[4], parseNumber(f[5], "seconds")}});
    } catch (const std::invalid_argument&) {
      continue;
    }
  }
  return rows;
}

/// What is known of a finished pair.
struct FinishedPair {
  std::size_t number = 0;
  std::vector<ResultRow> rows;
  std::vector<StageTime> stages;
};

/// The pairs of a run folder that have all their rows, in the order of pairs.csv. Throws RunFolderError
/// naming file, line and remedy.
std::vector<FinishedPair> finishedPairs(const fs::path& folder, const BenchmarkConfig& config) {
  const fs::path file = folder / "pairs.csv";
  const std::vector<std::string> lines = completeLines(readTextFile(file));
  if (!lines.empty() && lines.front() != pairsHeader()) {
    throw RunFolderError(file.string() +
                         " has another header than this version writes; give another output_dir");
  }
  std::vector<FinishedPair> pairs;
  std::map<PairId, std::size_t> index;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    try {
      const ResultRow row = ResultRow::fromCsv(lines[i]);
      const auto [found, is_new] = index.emplace(row.id, pairs.size());
      if (is_new) pairs.emplace_back();
      pairs[found->second].rows.push_back(row);
    } catch (const std::invalid_argument& problem) {
      throw RunFolderError(file.string() + ", line " + std::to_string(i + 1) + ": " + problem.what() +
                           "; remove the line or give another output_dir");
    }
  }
  for (const StageRow& row : readStages(folder / "stages.csv")) {
    const auto found = index.find(row.id);
    if (found == index.end()) continue;
    pairs[found->second].number = row.number;
    pairs[found->second].stages.push_back(row.stage);
  }
  const auto unfinished = [&config](const FinishedPair& pair) {
    return pair.stages.empty() || pair.rows.size() != expectedRows(config, pair.rows);
  };
  pairs.erase(std::remove_if(pairs.begin(), pairs.end(), unfinished), pairs.end());
  return pairs;
}

/// Throws RunFolderError naming the keys where the folder's configuration is another one.
void requireSameConfiguration(const std::string& folder, const BenchmarkConfig& config,
                              const std::string& remedy) {
  std::vector<std::string> differences;
  try {
    differences = yamlDifferences(readTextFile(fs::path(folder) / "config.yaml"), config.toYaml());
  } catch (const std::invalid_argument& problem) {
    throw RunFolderError(folder + "/config.yaml is damaged (" + problem.what() + "); " + remedy);
  }
  if (differences.empty()) return;
  throw RunFolderError("the folder " + folder + " holds a run of another configuration; it differs in:\n  " +
                       joinList(differences, "\n  ") + "\n" + remedy);
}

nlohmann::ordered_json jsonNumber(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

}  // namespace

std::string Shard::text() const {
  return count == 1 ? "" : std::to_string(index + 1) + "/" + std::to_string(count);
}

Shard Shard::fromText(const std::string& text) {
  if (text.empty()) return {};
  const std::size_t slash = text.find('/');
  const std::string wanted = "shard '" + text + "' does not read as i/n with 1 <= i <= n <= 100000, e.g. 2/8";
  if (slash == std::string::npos) throw std::invalid_argument(wanted);
  const int part = parseInteger(text.substr(0, slash), "shard");
  const int parts = parseInteger(text.substr(slash + 1), "shard");
  if (part < 1 || part > parts || parts > 100000) throw std::invalid_argument(wanted);
  return {static_cast<std::size_t>(part - 1), static_cast<std::size_t>(parts)};
}

RunFolder::RunFolder(const std::string& path, const BenchmarkConfig& config, bool resume) : path_(path) {
  std::error_code error;
  fs::create_directories(fs::path(path) / "images", error);
  if (error) {
    throw RunFolderError("cannot create the output folder " + path + ": " + error.message() +
                         "; give another output_dir or fix its permissions");
  }
  if (fs::exists(fs::path(path) / "config.yaml")) {
    requireSameConfiguration(path, config, "give another output_dir, or the same arguments as then");
    if (!resume) {
      throw RunFolderError(
          "the output folder " + path +
          " already holds a run of this configuration; continue it with resume:=true, or give "
          "another output_dir");
    }
    takeUp(config);
  } else if (fs::exists(fs::path(path) / "pairs.csv")) {
    throw RunFolderError("the output folder " + path +
                         " holds a pairs.csv without its config.yaml; give another output_dir");
  } else {
    writeFile(fs::path(path) / "pairs.csv", std::string(pairsHeader()) + "\n");
    writeFile(fs::path(path) / "stages.csv", std::string(kStagesHeader) + "\n");
    writeFile(fs::path(path) / "images" / "index.csv", std::string(kImagesHeader) + "\n");
    writeFile(fs::path(path) / "config.yaml", config.toYaml());
  }
  // Failed pairs are tried again by every session.
  writeFile(fs::path(path) / "failures.csv", std::string(kFailuresHeader) + "\n");
  const fs::path environment_file = fs::path(path) / "environment.json";
  nlohmann::ordered_json environment = nlohmann::ordered_json::parse(environmentJson(config.threads));
  const auto before = nlohmann::ordered_json::parse(readTextFile(environment_file), nullptr, false);
  if (before.is_object() && before.contains("merged_from"))
    environment["merged_from"] = before["merged_from"];
  writeFile(environment_file, environment.dump(2) + "\n");
}

void RunFolder::takeUp(const BenchmarkConfig& config) {
  for (const FinishedPair& pair : finishedPairs(path_, config)) done_.insert(pair.rows.front().id);
  const auto keep = [this](const char* name, std::size_t first_column, const char* header) {
    const fs::path file = fs::path(path_) / name;
    const std::string text = readTextFile(file);
    const std::string kept = text.empty() ? "" : keepPairs(text, first_column, done_);
    if (kept.empty() || kept != text) writeFile(file, kept.empty() ? std::string(header) + "\n" : kept);
  };
  keep("pairs.csv", 0, pairsHeader());
  keep("stages.csv", 1, kStagesHeader);
  keep("images/index.csv", 1, kImagesHeader);
}

void RunFolder::requireMergeable(const std::string& folder, const BenchmarkConfig& config) {
  if (!fs::exists(fs::path(folder) / "config.yaml") || !fs::exists(fs::path(folder) / "pairs.csv")) {
    throw RunFolderError("cannot merge " + folder +
                         ": it holds no run (no config.yaml and pairs.csv); name folders of runs");
  }
  requireSameConfiguration(folder, config,
                           "merge only runs that were given the same arguments, but for shard");
}

std::size_t RunFolder::merge(const std::string& folder, const BenchmarkConfig& config) {
  requireMergeable(folder, config);
  std::size_t taken = 0;
  for (const FinishedPair& pair : finishedPairs(folder, config)) {
    if (isDone(pair.rows.front().id)) continue;
    appendPair(pair.rows, pair.number, pair.stages);
    ++taken;
  }
  nlohmann::ordered_json environment, other;
  try {
    environment = nlohmann::ordered_json::parse(readTextFile(fs::path(path_) / "environment.json"));
    other = nlohmann::ordered_json::parse(readTextFile(fs::path(folder) / "environment.json"));
  } catch (const nlohmann::json::exception& problem) {
    throw RunFolderError("cannot merge " + folder + ": environment.json is damaged (" + problem.what() + ")");
  }
  other["pairs"] = taken;
  environment["merged_from"].push_back(other);
  writeFile(fs::path(path_) / "environment.json", environment.dump(2) + "\n");
  return taken;
}

bool RunFolder::isDone(const PairId& id) const { return done_.count(id) > 0; }

std::vector<ResultRow> RunFolder::readRows() const {
  const fs::path file = fs::path(path_) / "pairs.csv";
  return parseRows(file.string(), readTextFile(file));
}

void RunFolder::append(const std::string& file, const std::string& text) const {
  std::ofstream out(fs::path(path_) / file, std::ios::binary | std::ios::app);
  out << text;
  out.close();
  if (!out) {
    throw RunFolderError("cannot write to " + path_ + "/" + file +
                         ": check free space; what is there stays valid, continue with resume:=true");
  }
}

void RunFolder::appendPair(const std::vector<ResultRow>& rows, std::size_t number,
                           const std::vector<StageTime>& stages) {
  if (rows.empty()) return;
  const PairId& id = rows.front().id;
  std::string text;
  for (const StageTime& stage : stages) text += stageLine(std::to_string(number), id, stage);
  append("stages.csv", text);
  text.clear();
  for (const ResultRow& row : rows) text += row.toCsv() + "\n";
  append("pairs.csv", text);
  done_.insert(id);
}

void RunFolder::appendStage(const StageTime& stage, const std::string& dataset) {
  append("stages.csv", stageLine("", {dataset, "", ""}, stage));
}

void RunFolder::appendFailure(const Failure& failure) {
  append("failures.csv", csvLine({failure.id.dataset, failure.id.sequence, failure.id.pair, failure.features,
                                  failure.stage, failure.error}) +
                             "\n");
}

bool RunFolder::hasScaling() const { return fs::exists(fs::path(path_) / "scaling.csv"); }

void RunFolder::writeScaling(const std::vector<ScalingRow>& rows) const {
  std::string text = std::string(kScalingHeader) + "\n";
  for (const ScalingRow& row : rows) {
    text +=
        csvLine({row.selector, std::to_string(row.threads), std::to_string(row.n), std::to_string(row.round),
                 std::to_string(row.n_selected), toString(row.status), formatNumber(row.select_seconds)}) +
        "\n";
  }
  writeFile(fs::path(path_) / "scaling.csv", text);
}

std::vector<ExampleImage> RunFolder::readImages() const {
  std::vector<ExampleImage> images;
  const std::vector<std::string> lines =
      completeLines(readTextFile(fs::path(path_) / "images" / "index.csv"));
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> f = parseCsvLine(lines[i]);
    if (f.size() < 7) continue;
    ExampleImage image;
    image.file = f[0];
    image.id = {f[1], f[2], f[3]};
    image.features = f[4];
    image.preselection = f[5];
    image.selector = f[6];
    images.push_back(image);
  }
  return images;
}

void RunFolder::clearImages() const {
  for (const ExampleImage& image : readImages()) {
    std::error_code ignored;
    fs::remove(fs::path(path_) / "images" / safeFileName(image.file), ignored);
  }
  writeFile(fs::path(path_) / "images" / "index.csv", std::string(kImagesHeader) + "\n");
}

void RunFolder::appendImage(ExampleImage image, const cv::Mat& picture) {
  image.file = safeFileName(image.id.dataset + "_" + image.id.sequence + "_" + image.id.pair + "_" +
                            image.features + "_" + image.preselection + "_" + image.selector) +
               ".jpg";
  const std::string file = (fs::path(path_) / "images" / image.file).string();
  if (!cv::imwrite(file, picture, {cv::IMWRITE_JPEG_QUALITY, 85})) {
    throw RunFolderError("cannot write " + file + ": check permissions and free space of the folder");
  }
  append("images/index.csv",
         csvLine({image.file, image.id.dataset, image.id.sequence, image.id.pair, image.features,
                  image.preselection, image.selector, std::to_string(image.n_selected),
                  std::to_string(image.n_correct), std::to_string(image.n_wrong),
                  std::to_string(image.n_missed), formatNumber(image.tau)}) +
             "\n");
}

void RunFolder::sortPairs() const {
  std::map<PairId, std::size_t> numbers;
  for (const StageRow& row : readStages(fs::path(path_) / "stages.csv")) numbers[row.id] = row.number;
  const fs::path file = fs::path(path_) / "pairs.csv";
  const std::vector<std::string> lines = completeLines(readTextFile(file));
  std::vector<std::pair<std::size_t, std::size_t>> order;  // number of the pair, line
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> f = parseCsvLine(lines[i]);
    const auto found = numbers.find({f.at(0), f.at(1), f.at(2)});
    order.emplace_back(found == numbers.end() ? std::numeric_limits<std::size_t>::max() : found->second, i);
  }
  if (std::is_sorted(order.begin(), order.end())) return;
  std::sort(order.begin(), order.end());
  std::string text = std::string(pairsHeader()) + "\n";
  for (const auto& [number, line] : order) text += lines[line] + "\n";
  writeFile(file, text);
}

std::vector<SummaryRow> RunFolder::writeSummary(const RunState& state) const {
  sortPairs();
  std::vector<SummaryRow> summary = summarize(readRows());
  std::string csv = std::string(kSummaryHeader) + "\n";
  nlohmann::ordered_json json;
  json["state"] = {{"complete", state.complete()},
                   {"interrupted", state.interrupted},
                   {"pairs_done", state.pairs_done},
                   {"pairs_total", state.pairs_total},
                   {"pairs_failed", state.pairs_failed},
                   {"shard", state.shard},
                   {"peak_memory_mib", state.peak_memory_mib},
                   {"left_out_datasets", nlohmann::ordered_json::array()}};
  for (const auto& [dataset, reason] : state.left_out_datasets) {
    json["state"]["left_out_datasets"].push_back({{"dataset", dataset}, {"reason", reason}});
  }
  json["groups"] = nlohmann::ordered_json::array();
  for (const SummaryRow& row : summary) {
    csv += csvLine({row.dataset, row.features, row.preselection, row.selector, formatNumber(row.tau),
                    std::to_string(row.pairs), formatNumber(row.precision), formatNumber(row.recall_paper),
                    formatNumber(row.f_paper), formatNumber(row.f_low), formatNumber(row.f_high),
                    formatNumber(row.recall_same_tau), formatNumber(row.f_same_tau),
                    formatNumber(row.select_median), formatNumber(row.select_p95)}) +
           "\n";
    json["groups"].push_back({{"dataset", row.dataset},
                              {"features", row.features},
                              {"preselection", row.preselection},
                              {"selector", row.selector},
                              {"tau_px", jsonNumber(row.tau)},
                              {"pairs", row.pairs},
                              {"precision", jsonNumber(row.precision)},
                              {"recall_paper", jsonNumber(row.recall_paper)},
                              {"f_paper", jsonNumber(row.f_paper)},
                              {"f_paper_lo", jsonNumber(row.f_low)},
                              {"f_paper_hi", jsonNumber(row.f_high)},
                              {"recall_same_tau", jsonNumber(row.recall_same_tau)},
                              {"f_same_tau", jsonNumber(row.f_same_tau)},
                              {"select_s_median", jsonNumber(row.select_median)},
                              {"select_s_p95", jsonNumber(row.select_p95)}});
  }
  writeFile(fs::path(path_) / "summary.csv", csv);
  writeFile(fs::path(path_) / "summary.json", json.dump(2) + "\n");
  return summary;
}

}  // namespace corrsel::core
