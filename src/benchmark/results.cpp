#include "corrsel/benchmark/results.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <tuple>

#include "corrsel/benchmark/environment.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/text.h"

namespace corrsel::core {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPairsHeader =
    "dataset,sequence,pair,features,preselection,selector,tau_px,n_left,n_right,n_putative,n_ground_truth,n_"
    "selected,"
    "n_correct,precision,recall_paper,recall_same_tau,f_paper,f_same_tau,status,seed,detect_s,describe_s,"
    "match_s,"
    "select_s";
constexpr std::size_t kPairsColumns = 24;
constexpr const char* kSummaryHeader =
    "dataset,features,preselection,selector,tau_px,pairs,precision,recall_paper,f_paper,f_paper_lo,f_paper_"
    "hi,"
    "recall_same_tau,f_same_tau,select_s_median,select_s_p95";
constexpr const char* kStagesHeader = "number,dataset,sequence,pair,stage,seconds";
constexpr const char* kScalingHeader = "selector,threads,n,round,n_selected,status,select_s";
constexpr const char* kFailuresHeader = "dataset,sequence,pair,features,stage,error";
constexpr const char* kImagesHeader =
    "file,dataset,sequence,pair,features,preselection,selector,n_selected,n_correct,n_wrong,n_missed,tau_px";

std::string csvLine(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) line += (i ? "," : "") + csvField(fields[i]);
  return line;
}

double numberOrNan(const std::string& text, const char* column) {
  return text.empty() ? kUndefined : parseNumber(text, column);
}

std::size_t count(const std::string& text, const char* column) {
  const double value = numberOrNan(text, column);
  if (std::isnan(value)) return 0;
  // Beyond 2^53 not every whole number is a double.
  if (!(value >= 0 && value <= 9007199254740992.0) || value != std::floor(value)) {
    throw std::invalid_argument(std::string(column) + ": '" + text + "' is not a count");
  }
  return static_cast<std::size_t>(value);
}

std::string readFile(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

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

using PairKey = std::tuple<std::string, std::string, std::string>;

PairKey keyOf(const PairId& id) { return {id.dataset, id.sequence, id.pair}; }

/// Complete lines of a text; a last line that was cut off is left out.
std::vector<std::string> completeLines(const std::string& text) {
  std::vector<std::string> lines;
  std::size_t begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    lines.push_back(text.substr(begin, end - begin));
  }
  return lines;
}

/// Keeps the lines of a listing whose pair (three columns from `first_column`) is in `pairs`, or which are of
/// no pair.
std::string keepPairs(const std::string& text, std::size_t first_column, const std::set<PairKey>& pairs) {
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

bool near(double a, double b) { return std::isnan(a) ? std::isnan(b) : std::abs(a - b) <= 1e-6; }

/// Harmonic mean of correct / selected and correct / inliers; NaN where there is no inlier.
double fOfCounts(double correct, double selected, double inliers) {
  return inliers > 0 ? 2 * correct / (selected + inliers) : kUndefined;
}

/// What in a row cannot be; empty for a row as the benchmark writes it.
std::string contradictionIn(const ResultRow& row) {
  const Metrics& m = row.metrics;
  const auto exceeds = [](const char* part, std::size_t a, const char* whole, std::size_t b) {
    return std::string(part) + " = " + std::to_string(a) + " exceeds " + whole + " = " + std::to_string(b);
  };
  const auto differs = [](const char* name, double value, const std::string& of, double expected) {
    const auto text = [](double number) {
      return std::isnan(number) ? std::string("(empty)") : formatNumber(number);
    };
    return std::string(name) + " = " + text(value) + " instead of " + of + " = " + text(expected);
  };
  if (m.tau < 0 || std::isinf(m.tau)) return "tau_px = " + formatNumber(m.tau) + " is no tolerance";
  for (const auto& [name, seconds] : {std::pair{"detect_s", row.detect_seconds},
                                      {"describe_s", row.describe_seconds},
                                      {"match_s", row.match_seconds},
                                      {"select_s", row.select_seconds}}) {
    if (seconds < 0 || std::isinf(seconds)) {
      return std::string(name) + " = " + formatNumber(seconds) + " is no time";
    }
  }
  if (row.n_ground_truth > row.n_putative) {
    return exceeds("n_ground_truth", row.n_ground_truth, "n_putative", row.n_putative);
  }
  if (!row.judged()) {
    const bool empty = row.n_selected == 0 && m.n_correct == 0 && std::isnan(m.precision) &&
                       std::isnan(m.recall_paper) && std::isnan(m.recall_same_tau) && std::isnan(m.f_paper) &&
                       std::isnan(m.f_same_tau) && std::isnan(row.select_seconds);
    return empty ? "" : "status " + toString(row.status) + " beside numbers of a selection";
  }
  if (row.n_selected > row.n_putative) {
    return exceeds("n_selected", row.n_selected, "n_putative", row.n_putative);
  }
  if (m.n_correct > row.n_selected) {
    return exceeds("n_correct", m.n_correct, "n_selected", row.n_selected);
  }
  const double correct = static_cast<double>(m.n_correct), selected = static_cast<double>(row.n_selected),
               inliers = static_cast<double>(row.n_ground_truth);
  const double precision = row.n_selected > 0 ? correct / selected : kUndefined;
  if (!near(m.precision, precision)) {
    return differs("precision", m.precision, "n_correct / n_selected", precision);
  }
  const double recall = row.n_ground_truth > 0 ? correct / inliers : kUndefined;
  if (!near(m.recall_paper, recall)) {
    return differs("recall_paper", m.recall_paper, "n_correct / n_ground_truth", recall);
  }
  const double f = fOfCounts(correct, selected, inliers);
  if (!near(m.f_paper, f)) return differs("f_paper", m.f_paper, "the F of the counts", f);
  const bool none_correct = m.n_correct == 0, undefined = std::isnan(m.recall_same_tau);
  const bool possible =
      none_correct ? undefined || m.recall_same_tau == 0 : m.recall_same_tau > 0 && m.recall_same_tau <= 1;
  if (!possible) {
    return "recall_same_tau = " + formatNumber(m.recall_same_tau) +
           " with n_correct = " + std::to_string(m.n_correct);
  }
  double f_same_tau = undefined ? kUndefined : 0.0;
  if (!none_correct) f_same_tau = fOfCounts(correct, selected, correct / m.recall_same_tau);
  if (!near(m.f_same_tau, f_same_tau)) {
    return differs("f_same_tau", m.f_same_tau, "the F of precision and recall_same_tau", f_same_tau);
  }
  return "";
}

/// The rows of a pairs.csv; row i stands in line i + 2. A last line that was cut off is left out.
/// Throws RunFolderError: a line is no row, or is there twice.
std::vector<ResultRow> parseRows(const fs::path& file, const std::string& text) {
  const auto damaged = [&file](std::size_t row, const std::string& problem) {
    return RunFolderError(file.string() + ", line " + std::to_string(row + 2) + ": " + problem +
                          "; repair or remove the line, or run the benchmark again into another output_dir");
  };
  const std::vector<std::string> lines = completeLines(text);
  if (lines.empty() || lines.front() != kPairsHeader) {
    throw RunFolderError(file.string() +
                         ", line 1: is not the header that this version writes; run the benchmark again "
                         "into another output_dir");
  }
  std::vector<ResultRow> rows;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    try {
      rows.push_back(ResultRow::fromCsv(lines[i]));
    } catch (const std::invalid_argument& problem) {
      throw damaged(i - 1, problem.what());
    }
  }
  const auto key = [&rows](std::size_t i) {
    const ResultRow& row = rows[i];
    // Labelled rows have no tolerance, and NaN has no order.
    const double tau = std::isnan(row.metrics.tau) ? -1 : row.metrics.tau;
    return std::tuple<const std::string&, const std::string&, const std::string&, const std::string&,
                      const std::string&, const std::string&, double, int>(
        row.id.dataset, row.id.sequence, row.id.pair, row.features, row.preselection, row.selector, tau,
        row.seed);
  };
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&key](std::size_t a, std::size_t b) { return key(a) < key(b); });
  for (std::size_t k = 1; k < order.size(); ++k) {
    if (key(order[k - 1]) == key(order[k])) {
      throw damaged(order[k], "repeats the selection of line " + std::to_string(order[k - 1] + 2));
    }
  }
  return rows;
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
  const std::vector<std::string> lines = completeLines(readFile(file));
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> f = parseCsvLine(lines[i]);
    if (f.size() != 6 || f[0].empty()) continue;
    try {
      rows.push_back({count(f[0], "number"), {f[1], f[2], f[3]}, {f[4], numberOrNan(f[5], "seconds")}});
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
  const std::vector<std::string> lines = completeLines(readFile(file));
  if (!lines.empty() && lines.front() != kPairsHeader) {
    throw RunFolderError(file.string() +
                         " has another header than this version writes; give another output_dir");
  }
  std::vector<FinishedPair> pairs;
  std::map<PairKey, std::size_t> index;
  for (std::size_t i = 1; i < lines.size(); ++i) {
    try {
      const ResultRow row = ResultRow::fromCsv(lines[i]);
      const auto [found, is_new] = index.emplace(keyOf(row.id), pairs.size());
      if (is_new) pairs.emplace_back();
      pairs[found->second].rows.push_back(row);
    } catch (const std::invalid_argument& problem) {
      throw RunFolderError(file.string() + ", line " + std::to_string(i + 1) + ": " + problem.what() +
                           "; remove the line or give another output_dir");
    }
  }
  for (const StageRow& row : readStages(folder / "stages.csv")) {
    const auto found = index.find(keyOf(row.id));
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
    differences = yamlDifferences(readFile(fs::path(folder) / "config.yaml"), config.toYaml());
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

std::string ResultRow::toCsv() const {
  const bool numbers = judged();
  const auto number = [numbers](double value) { return numbers ? formatNumber(value) : std::string(); };
  const auto selected = [numbers](std::size_t value) {
    return numbers ? std::to_string(value) : std::string();
  };
  return csvLine({id.dataset,
                  id.sequence,
                  id.pair,
                  features,
                  preselection,
                  selector,
                  formatNumber(metrics.tau),
                  std::to_string(n_left),
                  std::to_string(n_right),
                  std::to_string(n_putative),
                  std::to_string(n_ground_truth),
                  selected(n_selected),
                  selected(metrics.n_correct),
                  number(metrics.precision),
                  number(metrics.recall_paper),
                  number(metrics.recall_same_tau),
                  number(metrics.f_paper),
                  number(metrics.f_same_tau),
                  toString(status),
                  std::to_string(seed),
                  formatNumber(detect_seconds),
                  formatNumber(describe_seconds),
                  formatNumber(match_seconds),
                  number(select_seconds)});
}

ResultRow ResultRow::fromCsv(const std::string& line) {
  const std::vector<std::string> f = parseCsvLine(line);
  if (f.size() != kPairsColumns) {
    throw std::invalid_argument("row has " + std::to_string(f.size()) + " columns instead of " +
                                std::to_string(kPairsColumns) + ": " + line);
  }
  ResultRow row;
  row.id = {f[0], f[1], f[2]};
  row.features = f[3];
  row.preselection = f[4];
  row.selector = f[5];
  row.metrics.tau = numberOrNan(f[6], "tau_px");
  row.n_left = count(f[7], "n_left");
  row.n_right = count(f[8], "n_right");
  row.n_putative = count(f[9], "n_putative");
  row.n_ground_truth = count(f[10], "n_ground_truth");
  row.n_selected = count(f[11], "n_selected");
  row.metrics.n_correct = count(f[12], "n_correct");
  row.metrics.precision = numberOrNan(f[13], "precision");
  row.metrics.recall_paper = numberOrNan(f[14], "recall_paper");
  row.metrics.recall_same_tau = numberOrNan(f[15], "recall_same_tau");
  row.metrics.f_paper = numberOrNan(f[16], "f_paper");
  row.metrics.f_same_tau = numberOrNan(f[17], "f_same_tau");
  row.status = statusFromString(f[18]);
  row.seed = parseInteger(f[19], "seed");
  row.detect_seconds = numberOrNan(f[20], "detect_s");
  row.describe_seconds = numberOrNan(f[21], "describe_s");
  row.match_seconds = numberOrNan(f[22], "match_s");
  row.select_seconds = numberOrNan(f[23], "select_s");
  return row;
}

std::vector<ResultRow> readResults(const std::string& folder) {
  const fs::path file = fs::path(folder) / "pairs.csv";
  if (!fs::is_regular_file(file)) {
    throw RunFolderError(file.string() + " does not exist: give the folder of a run, its output_dir");
  }
  const std::string text = readFile(file);
  std::vector<ResultRow> rows = parseRows(file, text);
  const auto at = [&file](std::size_t line) {
    return file.string() + ", line " + std::to_string(line) + ": ";
  };
  if (text.back() != '\n') {
    throw RunFolderError(at(rows.size() + 2) +
                         "is cut off; continue the run with resume:=true, or remove the line");
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const std::string problem = contradictionIn(rows[i]);
    if (problem.empty()) continue;
    throw RunFolderError(at(i + 2) + problem +
                         "; the line was changed after the run: run the benchmark again into another "
                         "output_dir");
  }
  return rows;
}

std::vector<SummaryRow> summarize(const std::vector<ResultRow>& rows) {
  // One pair's repetitions, averaged.
  struct PairValues {
    std::vector<double> precision, recall_paper, f_paper, recall_same_tau, f_same_tau;
  };
  struct Group {
    SummaryRow row;
    std::vector<PairKey> order;
    std::map<PairKey, PairValues> pairs;
    std::vector<double> seconds;
  };
  using GroupKey = std::tuple<std::string, std::string, std::string, std::string, std::string>;
  std::vector<Group> groups;
  std::map<GroupKey, std::size_t> index;
  for (const ResultRow& row : rows) {
    const GroupKey key{row.id.dataset, row.features, row.preselection, row.selector,
                       formatNumber(row.metrics.tau)};
    const auto [found, is_new] = index.emplace(key, groups.size());
    if (is_new) {
      groups.emplace_back();
      SummaryRow& head = groups.back().row;
      head.dataset = row.id.dataset;
      head.features = row.features;
      head.preselection = row.preselection;
      head.selector = row.selector;
      head.tau = row.metrics.tau;
    }
    Group& group = groups[found->second];
    if (!row.judged()) continue;
    group.seconds.push_back(row.select_seconds);
    if (row.n_ground_truth == 0) continue;
    const PairKey pair = keyOf(row.id);
    if (group.pairs.count(pair) == 0) group.order.push_back(pair);
    PairValues& values = group.pairs[pair];
    const auto add = [](std::vector<double>& list, double value) {
      if (!std::isnan(value)) list.push_back(value);
    };
    add(values.precision, row.metrics.precision);
    add(values.recall_paper, row.metrics.recall_paper);
    add(values.f_paper, row.metrics.f_paper);
    add(values.recall_same_tau, row.metrics.recall_same_tau);
    add(values.f_same_tau, row.metrics.f_same_tau);
  }
  std::vector<SummaryRow> summary;
  for (Group& group : groups) {
    const auto perPair = [&group](std::vector<double> PairValues::*member) {
      std::vector<double> means;
      for (const PairKey& pair : group.order) {
        const std::vector<double>& values = group.pairs[pair].*member;
        if (!values.empty()) means.push_back(mean(values));
      }
      return means;
    };
    SummaryRow& row = group.row;
    const std::vector<double> f = perPair(&PairValues::f_paper);
    row.pairs = group.order.size();
    row.precision = mean(perPair(&PairValues::precision));
    row.recall_paper = mean(perPair(&PairValues::recall_paper));
    row.f_paper = mean(f);
    const Interval interval = bootstrapMean(f, 0);
    row.f_low = interval.low;
    row.f_high = interval.high;
    row.recall_same_tau = mean(perPair(&PairValues::recall_same_tau));
    row.f_same_tau = mean(perPair(&PairValues::f_same_tau));
    row.select_median = quantile(group.seconds, 0.5);
    row.select_p95 = quantile(group.seconds, 0.95);
    summary.push_back(row);
  }
  return summary;
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
    writeFile(fs::path(path) / "pairs.csv", std::string(kPairsHeader) + "\n");
    writeFile(fs::path(path) / "stages.csv", std::string(kStagesHeader) + "\n");
    writeFile(fs::path(path) / "images" / "index.csv", std::string(kImagesHeader) + "\n");
    writeFile(fs::path(path) / "config.yaml", config.toYaml());
  }
  // Failed pairs are tried again by every session.
  writeFile(fs::path(path) / "failures.csv", std::string(kFailuresHeader) + "\n");
  const fs::path environment_file = fs::path(path) / "environment.json";
  nlohmann::ordered_json environment = nlohmann::ordered_json::parse(environmentJson(config.threads));
  const auto before = nlohmann::ordered_json::parse(readFile(environment_file), nullptr, false);
  if (before.is_object() && before.contains("merged_from"))
    environment["merged_from"] = before["merged_from"];
  writeFile(environment_file, environment.dump(2) + "\n");
}

void RunFolder::takeUp(const BenchmarkConfig& config) {
  for (const FinishedPair& pair : finishedPairs(path_, config)) done_.insert(keyOf(pair.rows.front().id));
  const auto keep = [this](const char* name, std::size_t first_column, const char* header) {
    const fs::path file = fs::path(path_) / name;
    const std::string text = readFile(file);
    const std::string kept = text.empty() ? "" : keepPairs(text, first_column, done_);
    if (kept.empty() || kept != text) writeFile(file, kept.empty() ? std::string(header) + "\n" : kept);
  };
  keep("pairs.csv", 0, kPairsHeader);
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
    environment = nlohmann::ordered_json::parse(readFile(fs::path(path_) / "environment.json"));
    other = nlohmann::ordered_json::parse(readFile(fs::path(folder) / "environment.json"));
  } catch (const nlohmann::json::exception& problem) {
    throw RunFolderError("cannot merge " + folder + ": environment.json is damaged (" + problem.what() + ")");
  }
  other["pairs"] = taken;
  environment["merged_from"].push_back(other);
  writeFile(fs::path(path_) / "environment.json", environment.dump(2) + "\n");
  return taken;
}

bool RunFolder::isDone(const PairId& id) const { return done_.count(keyOf(id)) > 0; }

std::vector<ResultRow> RunFolder::readRows() const {
  const fs::path file = fs::path(path_) / "pairs.csv";
  return parseRows(file, readFile(file));
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
  done_.insert(keyOf(id));
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
  const std::vector<std::string> lines = completeLines(readFile(fs::path(path_) / "images" / "index.csv"));
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
  std::map<PairKey, std::size_t> numbers;
  for (const StageRow& row : readStages(fs::path(path_) / "stages.csv")) numbers[keyOf(row.id)] = row.number;
  const fs::path file = fs::path(path_) / "pairs.csv";
  const std::vector<std::string> lines = completeLines(readFile(file));
  std::vector<std::pair<std::size_t, std::size_t>> order;  // number of the pair, line
  for (std::size_t i = 1; i < lines.size(); ++i) {
    const std::vector<std::string> f = parseCsvLine(lines[i]);
    const auto found = numbers.find({f.at(0), f.at(1), f.at(2)});
    order.emplace_back(found == numbers.end() ? std::numeric_limits<std::size_t>::max() : found->second, i);
  }
  if (std::is_sorted(order.begin(), order.end())) return;
  std::sort(order.begin(), order.end());
  std::string text = std::string(kPairsHeader) + "\n";
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
