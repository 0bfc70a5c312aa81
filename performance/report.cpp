#include "report.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <ostream>
#include <set>
#include <stdexcept>

#include "base/text.h"
#include "benchmark/environment.h"
#include "kernels/kernels.h"

namespace corrsel::performance {
namespace {

std::string fixed(double value, int digits) {
  if (std::isnan(value)) return "";
  char text[64];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  return text;
}

std::string padded(const std::string& text, std::size_t width) {
  return text.size() < width ? text + std::string(width - text.size(), ' ') : text;
}

double ratio(const Row& row) { return row.peer.milliseconds / row.ours.milliseconds; }

std::string identical(const Row& row) {
  if (!row.same_mask || !row.peer.failure.empty()) return "-";
  return row.differing == 0 ? "yes" : "NO: " + std::to_string(row.differing) + " differ";
}

std::string against(const Row& row) { return row.peer.name.empty() ? "-" : row.peer.name; }

/// The cells of a comparison, as in the table's header.
std::vector<std::string> cells(const Row& row) {
  const bool failed = !row.peer.failure.empty();
  return {row.ours.name,
          against(row),
          std::to_string(row.scene.n),
          core::formatNumber(row.scene.inlier_ratio),
          shortNumber(row.ours.milliseconds),
          failed ? "failed: " + row.peer.failure.substr(0, 40) : shortNumber(row.peer.milliseconds),
          std::isnan(ratio(row)) ? "" : shortNumber(ratio(row)) + "x",
          fixed(row.ours.f, 1),
          fixed(row.peer.f, 1),
          identical(row)};
}

const std::vector<std::string> kHeader = {"selector", "against", "N",      "eps",    "ours ms",
                                          "peer ms",  "ratio",   "F ours", "F peer", "identical masks"};
constexpr std::size_t kWidths[] = {27, 28, 7, 4, 8, 8, 7, 7, 7, 1};

std::string consoleLine(const std::vector<std::string>& values) {
  std::string line;
  for (std::size_t i = 0; i < values.size(); ++i) line += padded(values[i], kWidths[i]) + " ";
  return line + "\n";
}

std::string markdownLine(const std::vector<std::string>& values) {
  return "| " + core::joinList(values, " | ") + " |\n";
}

std::string markdownHeader(const std::vector<std::string>& values) {
  return "\n" + markdownLine(values) + markdownLine(std::vector<std::string>(values.size(), "---"));
}

std::string limitText(std::size_t limit) { return limit == 0 ? "all" : std::to_string(limit); }

const std::vector<std::string> kFeatureHeader = {"features",   "against", "image",   "limit", "found",
                                                 "peer found", "ours ms", "peer ms", "ratio", "N"};

std::vector<std::string> cells(const FeatureRow& row) {
  const bool alone = row.peer.name.empty(), failed = !row.peer.failure.empty();
  const double factor = row.peer.milliseconds / row.ours.milliseconds;
  return {row.ours.name,
          alone ? "-" : row.peer.name,
          row.image,
          limitText(row.limit),
          std::to_string(row.ours_n),
          alone || failed ? "" : std::to_string(row.peer_n),
          shortNumber(row.ours.milliseconds),
          failed ? "failed: " + row.peer.failure.substr(0, 40) : shortNumber(row.peer.milliseconds),
          std::isnan(factor) ? "" : shortNumber(factor) + "x",
          std::to_string(row.ours.repetitions)};
}

const std::vector<std::string> kStageHeader = {"features",    "image",       "limit",   "found",
                                               "features ms", "matching ms", "usac ms", "share of features"};

std::vector<std::string> cells(const StageRow& row) {
  const double features = row.features.milliseconds;
  const double total = features + row.matching.milliseconds + row.selection.milliseconds;
  return {row.features.name,
          row.image,
          limitText(row.limit),
          std::to_string(row.n),
          shortNumber(features),
          shortNumber(row.matching.milliseconds),
          shortNumber(row.selection.milliseconds),
          fixed(100 * features / total, 0) + " %"};
}

const std::vector<std::string> kCostHeader = {
    "features", "image", "found", "search ms", "+ each keypoint ms", "+ description ms", "per feature us"};

std::vector<std::string> cells(const CostRow& row) {
  const double keypoints = row.detection.milliseconds - row.search.milliseconds;
  const double description = row.all.milliseconds - row.detection.milliseconds;
  return {row.features,
          row.image,
          std::to_string(row.n),
          shortNumber(row.search.milliseconds),
          shortNumber(std::max(0.0, keypoints)),
          shortNumber(std::max(0.0, description)),
          shortNumber(1e3 * (row.all.milliseconds - row.search.milliseconds) / double(row.n))};
}

using Record = std::map<std::string, std::string>;  // column -> value

constexpr const char* kColumns[] = {"comparison",
                                    "selector",
                                    "against",
                                    "scene",
                                    "n",
                                    "inlier_ratio",
                                    "ours_ms",
                                    "ours_lower_quartile_ms",
                                    "ours_upper_quartile_ms",
                                    "ours_repetitions",
                                    "peer_ms",
                                    "peer_lower_quartile_ms",
                                    "peer_upper_quartile_ms",
                                    "peer_repetitions",
                                    "ratio",
                                    "ours_precision",
                                    "ours_recall",
                                    "ours_f",
                                    "peer_precision",
                                    "peer_recall",
                                    "peer_f",
                                    "identical_masks",
                                    "exponent",
                                    "found",
                                    "failure",
                                    "cpu",
                                    "threads",
                                    "compiler",
                                    "build_type",
                                    "opencv",
                                    "corrsel_commit",
                                    "kernels"};

std::string sceneName(const SceneSpec& scene) {
  // Matchers are timed on descriptors, which have no inlier ratio.
  if (std::isnan(scene.inlier_ratio)) return "descriptors";
  switch (scene.kind) {
    case MatchSceneKind::kPlane:
      return "plane";
    case MatchSceneKind::kSpace:
      return "space";
    case MatchSceneKind::kTwoPlanes:
      return "two planes";
    default:
      return "other";
  }
}

/// Times and quality of one side of a comparison.
void describe(const std::string& side, const Measurement& m, Record& record) {
  record[side + "_ms"] = core::formatNumber(m.milliseconds);
  record[side + "_lower_quartile_ms"] = core::formatNumber(m.lower_quartile);
  record[side + "_upper_quartile_ms"] = core::formatNumber(m.upper_quartile);
  record[side + "_repetitions"] = m.repetitions ? std::to_string(m.repetitions) : "";
  record[side + "_precision"] = core::formatNumber(m.precision);
  record[side + "_recall"] = core::formatNumber(m.recall);
  record[side + "_f"] = core::formatNumber(m.f);
}

/// The columns on machine and program, which are the same in all rows.
Record machineRecord() {
  Record machine;
  const auto environment = nlohmann::json::parse(core::environmentJson(1));
  for (const char* name : {"cpu", "threads", "compiler", "build_type", "opencv", "corrsel_commit"}) {
    const auto& value = environment[name];
    machine[name] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  machine["kernels"] = core::toString(core::kernelLevel());
  return machine;
}

Record recordOf(const std::string& comparison, const std::string& selector, const std::string& scene,
                std::size_t n, const Measurement& ours) {
  Record record = {
      {"comparison", comparison}, {"selector", selector}, {"scene", scene}, {"n", std::to_string(n)}};
  describe("ours", ours, record);
  return record;
}

Record recordOf(const Row& row) {
  Record record = recordOf(row.comparison, row.ours.name, sceneName(row.scene), row.scene.n, row.ours);
  record["against"] = row.peer.name;
  record["inlier_ratio"] = core::formatNumber(row.scene.inlier_ratio);
  record["ratio"] = core::formatNumber(ratio(row));
  record["failure"] = row.peer.failure;
  describe("peer", row.peer, record);
  if (row.same_mask && row.peer.failure.empty()) record["identical_masks"] = row.differing ? "no" : "yes";
  return record;
}

Record recordOf(const FeatureRow& row) {
  Record record = recordOf(row.comparison, row.ours.name, row.image, row.ours_n, row.ours);
  record["against"] = row.peer.name;
  record["ratio"] = core::formatNumber(row.peer.milliseconds / row.ours.milliseconds);
  record["failure"] = row.peer.failure;
  describe("peer", row.peer, record);
  if (row.must_be_identical) record["identical_masks"] = row.same ? "yes" : "no";
  return record;
}

}  // namespace

std::string shortNumber(double value) {
  if (std::isnan(value)) return "";
  const int before = value >= 1 ? int(std::log10(value)) + 1 : 1;
  return fixed(value, std::clamp(3 - before, value < 0.1 ? 4 : 0, 4));
}

void Report::add(const Row& row) {
  rows_.push_back(row);
  new_lines_ += consoleLine(cells(row));
}

void Report::add(const GrowthRow& row) {
  growth_.push_back(row);
  for (std::size_t i = 0; i < row.sizes.size(); ++i) {
    const bool last = i + 1 == row.sizes.size();
    new_lines_ += consoleLine({row.comparison, "itself at other sizes", std::to_string(row.sizes[i]), "",
                               shortNumber(row.measured[i].milliseconds), "",
                               last ? "N^" + fixed(row.exponent, 2) : ""});
  }
}

void Report::add(const FeatureRow& row) {
  features_.push_back(row);
  const std::vector<std::string> values = cells(row);
  new_lines_ +=
      consoleLine({values[0] + " " + values[2], values[1], values[4], "", values[6], values[7], values[8]});
}

void Report::add(const StageRow& row) {
  stages_.push_back(row);
  for (const Measurement* stage : {&row.features, &row.matching, &row.selection}) {
    const std::string what = stage == &row.features ? "" : stage->name + " of ";
    new_lines_ += consoleLine({what + row.features.name + " " + row.image, "- (both images)",
                               std::to_string(row.n), "", shortNumber(stage->milliseconds)});
  }
}

void Report::add(const CostRow& row) {
  costs_.push_back(row);
  for (const Measurement* stage : {&row.search, &row.detection, &row.all}) {
    new_lines_ +=
        consoleLine({(stage == &row.all ? "" : stage->name + " of ") + row.features + " " + row.image, "-",
                     std::to_string(row.n), "", shortNumber(stage->milliseconds)});
  }
}

void Report::add(const HardRow& row) {
  hard_.push_back(row);
  new_lines_ += consoleLine({row.comparison, row.method, "", core::formatNumber(row.inlier_ratio),
                             shortNumber(row.milliseconds), "",
                             std::to_string(row.found) + "/" + std::to_string(row.seeds) + " found"});
}

void Report::add(const Verdict& verdict) { verdicts_.push_back(verdict); }

void Report::addFailure(const std::string& comparison, const std::string& reason) {
  failures_.emplace_back(comparison, reason);
  new_lines_ += padded(comparison, kWidths[0]) + " SKIPPED: " + reason + "\n";
}

std::string Report::newLines() { return std::exchange(new_lines_, ""); }

std::string Report::targets() const {
  std::string text;
  std::size_t met = 0;
  for (const Verdict& verdict : verdicts_) {
    text += (verdict.passed ? "PASS  " : "FAIL  ") + verdict.text + "\n";
    if (verdict.passed) ++met;
  }
  for (const auto& [comparison, reason] : failures_) text += "SKIP  " + comparison + ": " + reason + "\n";
  if (!verdicts_.empty())
    text += std::to_string(met) + " of " + std::to_string(verdicts_.size()) + " targets are met\n";
  return text;
}

std::string Report::markdown(const std::string& command) const {
  std::string text = "Written by `" + command + "` on: " + machine() + ".\n";
  if (!verdicts_.empty()) {
    text += "\n### Targets\n" + markdownHeader({"", "target and measurement"});
    for (const Verdict& v : verdicts_) text += markdownLine({v.passed ? "PASS" : "**FAIL**", v.text});
  }
  if (!rows_.empty()) {
    text += "\n### Beside what users would pick instead\n" + markdownHeader(kHeader);
    for (const Row& row : rows_) text += markdownLine(cells(row));
  }
  if (!features_.empty()) {
    text += "\n### Features of one image\n" + markdownHeader(kFeatureHeader);
    for (const FeatureRow& row : features_) text += markdownLine(cells(row));
  }
  if (!stages_.empty()) {
    text += "\n### Where the time of a pair goes\n" + markdownHeader(kStageHeader);
    for (const StageRow& row : stages_) text += markdownLine(cells(row));
  }
  if (!costs_.empty()) {
    text += "\n### What the stages of features cost\n" + markdownHeader(kCostHeader);
    for (const CostRow& row : costs_) text += markdownLine(cells(row));
  }
  if (!growth_.empty()) {
    std::set<std::size_t> sizes;
    for (const GrowthRow& row : growth_) sizes.insert(row.sizes.begin(), row.sizes.end());
    std::vector<std::string> header = {"selector"};
    for (const std::size_t n : sizes) header.push_back("N=" + std::to_string(n) + ", ms");
    header.push_back("exponent");
    text += "\n### Growth with N\n" + markdownHeader(header);
    for (const GrowthRow& row : growth_) {
      std::vector<std::string> line = {row.comparison.substr(row.comparison.find('/') + 1)};
      for (const std::size_t n : sizes) {
        const auto found = std::find(row.sizes.begin(), row.sizes.end(), n);
        line.push_back(found == row.sizes.end()
                           ? "-"
                           : shortNumber(row.measured[std::size_t(found - row.sizes.begin())].milliseconds));
      }
      line.push_back(fixed(row.exponent, 2));
      text += markdownLine(line);
    }
  }
  if (!hard_.empty()) {
    text += "\n### Finding the model when it is hard\n" +
            markdownHeader({"inlier ratio", "method", "found", "median ms"});
    for (const HardRow& row : hard_) {
      text += markdownLine({core::formatNumber(row.inlier_ratio), row.method,
                            std::to_string(row.found) + " of " + std::to_string(row.seeds),
                            shortNumber(row.milliseconds)});
    }
  }
  if (!failures_.empty()) text += "\nNot measured:\n\n";
  for (const auto& [comparison, reason] : failures_) text += "- " + comparison + ": " + reason + "\n";
  return text;
}

void Report::writeCsv(std::ostream& out) const {
  const Record machine = machineRecord();
  const auto write = [&](Record record) {
    record.insert(machine.begin(), machine.end());
    std::vector<std::string> fields;
    for (const char* column : kColumns) fields.push_back(core::csvField(record[column]));
    out << core::joinList(fields, ",") << '\n';
  };
  out << core::joinList({std::begin(kColumns), std::end(kColumns)}, ",") << '\n';
  for (const Row& row : rows_) write(recordOf(row));
  for (const GrowthRow& row : growth_) {
    for (std::size_t i = 0; i < row.sizes.size(); ++i) {
      Record record = recordOf(row.comparison, row.comparison.substr(row.comparison.find('/') + 1), "",
                               row.sizes[i], row.measured[i]);
      if (i + 1 == row.sizes.size()) record["exponent"] = core::formatNumber(row.exponent);
      write(record);
    }
  }
  for (const FeatureRow& row : features_) write(recordOf(row));
  for (const StageRow& row : stages_) {
    for (const Measurement* stage : {&row.features, &row.matching, &row.selection})
      write(recordOf(row.comparison, stage->name, row.image, row.n, *stage));
  }
  for (const CostRow& row : costs_) {
    for (const Measurement* stage : {&row.search, &row.detection, &row.all})
      write(recordOf(row.comparison, stage->name, row.image, row.n, *stage));
  }
  for (const HardRow& row : hard_) {
    write({{"comparison", row.comparison},
           {"selector", row.method},
           {"scene", "plane"},
           {"inlier_ratio", core::formatNumber(row.inlier_ratio)},
           {"ours_ms", core::formatNumber(row.milliseconds)},
           {"ours_repetitions", std::to_string(row.seeds)},
           {"found", std::to_string(row.found)}});
  }
  for (const auto& [comparison, reason] : failures_) write({{"comparison", comparison}, {"failure", reason}});
}

bool Report::good() const {
  return failures_.empty() &&
         std::all_of(rows_.begin(), rows_.end(),
                     [](const Row& row) { return !row.same_mask || row.differing == 0; }) &&
         std::all_of(features_.begin(), features_.end(),
                     [](const FeatureRow& row) { return !row.must_be_identical || row.same; }) &&
         std::all_of(verdicts_.begin(), verdicts_.end(), [](const Verdict& v) { return v.passed; });
}

std::string Report::consoleHeader() { return consoleLine(kHeader); }

std::string Report::machine() {
  const auto environment = nlohmann::json::parse(core::environmentJson(1));
  const auto text = [&environment](const char* name) { return environment[name].get<std::string>(); };
  return text("cpu") + ", 1 thread, " + text("compiler") + ", " + text("build_type") + ", OpenCV " +
         text("opencv") + ", " + core::toString(core::kernelLevel()) + " kernels, commit " +
         text("corrsel_commit");
}

void writeMarkdown(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  if (!(out << text << std::flush)) throw std::runtime_error("cannot write " + file);
}

}  // namespace corrsel::performance
