#include "programs/verify/report.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <system_error>

#include "base/ordered_json.h"
#include "base/temporary_folder.h"
#include "base/text.h"
#include "corrsel/evaluation/statistics.h"
#include "programs/started_programs.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;
using core::TwoViewConfig;

constexpr std::size_t kFaultsShown = 20;  // on a terminal; the files have all
constexpr std::array<double, 5> kQuantiles = {0, 0.25, 0.5, 0.75, 1};

std::string fixed(double value, int digits) {
  std::ostringstream text;
  text.setf(std::ios::fixed);
  text.precision(digits);
  text << value;
  return text.str();
}

std::string row(const std::string& name, const std::string& value) {
  constexpr std::size_t kWidth = 24;
  return "  " + name + std::string(name.size() < kWidth ? kWidth - name.size() : 1, ' ') + value + "\n";
}

std::string row(const std::string& name, std::size_t value) { return row(name, std::to_string(value)); }

/// Numbers of pairs: accepted ones by what was found, the others by status.
struct Counts {
  explicit Counts(const VerifyReport& report) {
    for (const ReportPair& pair : report.pairs) {
      if (pair.accepted()) {
        ++accepted;
        ++configs.at(static_cast<std::size_t>(pair.config));
        if (!std::isnan(pair.confidence)) confidences.push_back(pair.confidence);
      } else {
        ++statuses[toString(pair.status)];
      }
    }
  }

  std::size_t accepted = 0;
  std::array<std::size_t, 9> configs{};
  std::map<std::string, std::size_t> statuses;
  std::vector<double> confidences;  ///< of accepted pairs
};

/// Quantiles of the confidences of the accepted pairs; empty where there are none.
std::vector<double> confidenceQuantiles(const Counts& counts) {
  std::vector<double> values;
  if (counts.confidences.empty()) return values;
  for (double q : kQuantiles) values.push_back(core::quantile(counts.confidences, q));
  return values;
}

/// Wall and processor time of a pair, ms; NaN where none was verified.
std::pair<double, double> millisecondsPerPair(const VerifyReport& report) {
  const double n = static_cast<double>(report.summary.verified);
  if (n == 0) return {std::nan(""), std::nan("")};
  return {1000 * report.summary.seconds / n, 1000 * report.processor_seconds / n};
}

std::string nameOf(const VerifyReport& report, std::uint32_t id) {
  const auto found = std::lower_bound(
      report.images.begin(), report.images.end(), id,
      [](const core::StoredImage& image, std::uint32_t wanted) { return image.id < wanted; });
  return found != report.images.end() && found->id == id ? found->name : std::to_string(id);
}

std::string namesOf(const VerifyReport& report, const core::ImagePairKey& pair) {
  return nameOf(report, pair.first) + ", " + nameOf(report, pair.second);
}

std::string resultLines(const VerifyReport& report) {
  const Counts counts(report);
  std::string text = row("accepted", counts.accepted);
  for (std::size_t k = 0; k < counts.configs.size(); ++k) {
    if (counts.configs[k] > 0) text += row("  " + toString(static_cast<TwoViewConfig>(k)), counts.configs[k]);
  }
  text += row("rejected", report.pairs.size() - counts.accepted);
  for (const auto& [status, number] : counts.statuses) {
    text += row("  " + (status == "ok" ? "too few inliers" : status), number);
  }
  const std::vector<double> quantiles = confidenceQuantiles(counts);
  if (!quantiles.empty()) {
    text += row("confidence", fixed(quantiles[0], 1) + " to " + fixed(quantiles[4], 1) + ", median " +
                                  fixed(quantiles[2], 1) + " (accepted pairs)");
  }
  return text;
}

std::string faultLines(const VerifyReport& report) {
  std::string text;
  for (std::size_t i = 0; i < std::min(report.faulty.size(), kFaultsShown); ++i) {
    text += "  faulty: " + namesOf(report, report.faulty[i].first) + ": " + report.faulty[i].second + "\n";
  }
  if (report.faulty.size() > kFaultsShown) {
    text += "  " + std::to_string(report.faulty.size() - kFaultsShown) +
            " more faulty pairs; --report FILE.csv lists all\n";
  }
  return text;
}

core::OrderedJson numberOrNull(double value) {
  return std::isfinite(value) ? core::OrderedJson(value) : core::OrderedJson(nullptr);
}

core::OrderedJson countsJson(const VerifyReport& report) {
  const Counts counts(report);
  core::OrderedJson configs = core::OrderedJson::object(), statuses = core::OrderedJson::object();
  for (std::size_t k = 0; k < counts.configs.size(); ++k) {
    if (counts.configs[k] > 0) configs[toString(static_cast<TwoViewConfig>(k))] = counts.configs[k];
  }
  for (const auto& [status, number] : counts.statuses) statuses[status] = number;
  return {{"accepted", counts.accepted},
          {"rejected", report.pairs.size() - counts.accepted},
          {"configs", configs},
          {"rejected_by_status", statuses},
          {"confidence_quantiles", confidenceQuantiles(counts)}};
}

/// Adds what is known of tracks and cycles.
void addGraph(const VerifyReport& report, core::OrderedJson& out) {
  if (report.tracks) {
    const core::TrackStatistics& tracks = *report.tracks;
    out["tracks"] = {{"tracks", tracks.tracks},
                     {"observations", tracks.observations},
                     {"mean_length", numberOrNull(tracks.mean_length)},
                     {"matches", tracks.matches},
                     {"cut", tracks.cut},
                     {"lengths", tracks.lengths}};
  }
  if (report.cycles) {
    const core::CycleReport& cycles = *report.cycles;
    core::OrderedJson accused = core::OrderedJson::array();
    for (const core::PairCycles& pair : cycles.pairs) {
      if (pair.accused)
        accused.push_back({nameOf(report, pair.pair.first), nameOf(report, pair.pair.second)});
    }
    out["cycles"] = {{"triplets", cycles.triplets},
                     {"failing", cycles.failing},
                     {"accused", cycles.accused},
                     {"unchecked", cycles.unchecked},
                     {"accused_pairs", accused}};
  }
}

std::string jsonText(const VerifyReport& report) {
  const core::VerificationSummary& summary = report.summary;
  const auto [wall, processor] = millisecondsPerPair(report);
  core::OrderedJson faulty = core::OrderedJson::array(), images = core::OrderedJson::array();
  for (const auto& [pair, message] : report.faulty) {
    faulty.push_back({{"image1", nameOf(report, pair.first)},
                      {"image2", nameOf(report, pair.second)},
                      {"message", message}});
  }
  for (const core::StoredImage& image : report.images) images.push_back(image.name);
  core::OrderedJson out = {
      {"database", report.database},
      {"result", report.result},
      {"configuration", report.configuration},
      {"shard", report.shard.empty() ? core::OrderedJson(nullptr) : core::OrderedJson(report.shard)},
      {"checksum", report.checksum.empty() ? core::OrderedJson(nullptr) : core::OrderedJson(report.checksum)},
      {"dry_run", report.dry_run},
      {"interrupted", summary.interrupted},
      {"pairs",
       {{"asked", summary.pairs},
        {"verified_before", summary.skipped},
        {"verified_by_other_programs", report.of_others},
        {"verified", summary.verified},
        {"faulty", summary.faulty}}}};
  out["results"] = countsJson(report);
  out["run"] = {{"threads", report.threads},
                {"seconds", summary.seconds},
                {"processor_seconds", report.processor_seconds},
                {"ms_per_pair", numberOrNull(wall)},
                {"processor_ms_per_pair", numberOrNull(processor)},
                {"peak_memory_mib", report.peak_memory_mib}};
  addGraph(report, out);
  out["warnings"] = report.warnings;
  out["faulty"] = faulty;
  out["images"] = images;
  return out.dump(1, ' ', false, core::OrderedJson::error_handler_t::replace) + "\n";
}

void writeFile(const fs::path& path, const std::string& text) {
  std::ofstream out(path, std::ios::binary);
  out << text;
  out.close();
  if (!out) {
    throw core::StoreError(core::StoreError::Kind::kStorage,
                           path.string() +
                               " cannot be written; the results are stored, so the same command with "
                               "another --report only writes the report");
  }
}

void writeCsv(const VerifyReport& report, const fs::path& path) {
  std::string text = "image1,image2,raw,kept,status,confidence,config,ambiguity,message\n";
  auto fault = report.faulty.begin();
  const auto addFaulty = [&] {
    text += core::csvLine({nameOf(report, fault->first.first), nameOf(report, fault->first.second), "", "",
                           "faulty", "", "", "", fault->second}) +
            "\n";
    ++fault;
  };
  for (const ReportPair& pair : report.pairs) {
    while (fault != report.faulty.end() && fault->first < pair.pair) addFaulty();
    text += core::csvLine({nameOf(report, pair.pair.first), nameOf(report, pair.pair.second),
                           std::to_string(pair.raw), std::to_string(pair.kept), toString(pair.status),
                           core::formatNumber(pair.confidence), toString(pair.config),
                           core::formatNumber(pair.ambiguity), ""}) +
            "\n";
  }
  while (fault != report.faulty.end()) addFaulty();
  writeFile(path, text);
}

/// The page is made by the Python package from the other two forms.
void writePage(const VerifyReport& report, const fs::path& path) {
  const core::TemporaryFolder folder("corrsel_verify");
  const fs::path csv = folder.path() / "pairs.csv", json = folder.path() / "summary.json";
  writeCsv(report, csv);
  writeFile(json, jsonText(report));
  if (runPython("corrsel.report.verification", {csv.string(), json.string(), path.string()}) == 0) return;
  throw core::StoreError(core::StoreError::Kind::kStorage,
                         path.string() +
                             " could not be made, see the message above; the results are stored, so "
                             "the same command only writes the report");
}

}  // namespace

ReportPair reportPair(const core::VerifiedPair& pair) {
  ReportPair row;
  row.pair = pair.pair;
  row.raw = static_cast<std::uint32_t>(pair.putative);
  row.kept = static_cast<std::uint32_t>(pair.geometry.inliers.size());
  row.status = pair.status;
  row.config = pair.geometry.config;
  row.confidence = pair.confidence;
  row.ambiguity = pair.ambiguity;
  return row;
}

std::string reportText(const VerifyReport& report) {
  const core::VerificationSummary& summary = report.summary;
  std::string text = report.database + (report.shard.empty() ? "" : ", part " + report.shard) + ": " +
                     std::to_string(summary.pairs) + " pairs\n";
  text += row("verified by this run", summary.verified) + row("verified before", summary.skipped);
  if (report.of_others > 0)
    text += row("by other programs", std::to_string(report.of_others) + " (--again replaces them)");
  if (summary.faulty > 0) text += row("faulty", summary.faulty);
  text += resultLines(report);
  if (summary.verified > 0) {
    const auto [wall, processor] = millisecondsPerPair(report);
    text += row("time", fixed(summary.seconds, 1) + " s on " + std::to_string(report.threads) + " threads, " +
                            fixed(wall, 2) + " ms a pair (processor: " + fixed(processor, 2) + " ms)");
  }
  if (report.cycles) {
    text += row("triplets of images",
                std::to_string(report.cycles->triplets) + ", " + std::to_string(report.cycles->failing) +
                    " do not close and accuse " + std::to_string(report.cycles->accused) + " pairs");
  }
  if (report.tracks) {
    text += row("tracks", std::to_string(report.tracks->tracks) + " of " +
                              fixed(report.tracks->mean_length, 2) + " keypoints on average");
  }
  text += row("memory", fixed(report.peak_memory_mib, 0) + " MiB at most");
  if (!report.checksum.empty()) text += row("checksum of the rows", report.checksum);
  text += faultLines(report);
  for (const std::string& warning : report.warnings) text += "  warning: " + warning + "\n";
  if (report.dry_run) return text + "dry run: nothing was written\n";
  return text +
         (summary.interrupted ? "interrupted; the same command continues. Results so far: " : "results: ") +
         report.result + "\n";
}

void writeReports(const VerifyReport& report, const std::vector<fs::path>& files) {
  for (const fs::path& file : files) {
    const std::string form = file.extension().string();
    if (form == ".csv") writeCsv(report, file);
    if (form == ".json") writeFile(file, jsonText(report));
    if (form == ".html") writePage(report, file);
  }
}

}  // namespace corrsel
