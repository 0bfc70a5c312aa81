#include "corrsel/benchmark/comparison.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>
#include <utility>

#include "base/text.h"
#include "corrsel/benchmark/config.h"
#include "corrsel/evaluation/pose.h"

namespace corrsel::core {
namespace {

constexpr std::pair<const char*, double Metrics::*> kMetrics[] = {
    {"f_paper", &Metrics::f_paper},
    {"f_same_tau", &Metrics::f_same_tau},
    {"precision", &Metrics::precision},
    {"recall_paper", &Metrics::recall_paper},
    {"recall_same_tau", &Metrics::recall_same_tau},
};

double accuracyOf(double error) { return std::isnan(error) ? kUndefined : thresholdAccuracy(error); }

constexpr std::pair<const char*, double (*)(const PoseRow&)> kPoseMetrics[] = {
    {"pose_maa", [](const PoseRow& row) { return accuracyOf(row.pose_error); }},
    {"corner_maa", [](const PoseRow& row) { return accuracyOf(row.corner_error); }},
    {"epipolar_precision", [](const PoseRow& row) { return row.epipolar_precision; }},
};

void requireMetric(const std::string& name) {
  const std::vector<std::string> names = comparisonMetrics();
  if (std::find(names.begin(), names.end(), name) != names.end()) return;
  throw std::invalid_argument("unknown metric '" + name + "'" + validNames(name, names));
}

/// Dataset, features, preselection, selector.
using GroupKey = std::tuple<std::string, std::string, std::string, std::string>;
/// Sequence, pair.
using PairKey = std::pair<std::string, std::string>;

/// The values of the repetitions of one selection.
struct PairValues {
  std::vector<double> values;   ///< defined ones
  std::vector<double> seconds;  ///< known ones
  Status status = Status::kOk;
};

struct RunTable {
  std::vector<GroupKey> order;
  std::map<GroupKey, std::map<PairKey, PairValues>> groups;
  std::map<GroupKey, double> tau;
};

/// The values of the repetitions of the row's selection.
template <class Row>
PairValues& valuesOf(const Row& row, double tau, RunTable& table) {
  const GroupKey key{row.id.dataset, row.features, row.preselection, row.selector};
  const auto [group, is_new] = table.groups.try_emplace(key);
  if (is_new) {
    table.order.push_back(key);
    table.tau[key] = tau;
  }
  PairValues& pair = group->second[{row.id.sequence, row.id.pair}];
  pair.status = row.status;
  return pair;
}

/// Rows of pairs whose measure is not known are left out.
RunTable poseTableOf(const RecordedRun& run, double (*metric)(const PoseRow&)) {
  RunTable table;
  for (const PoseRow& row : run.poses) {
    const double value = metric(row);
    if (std::isnan(value) && row.evaluated()) continue;
    PairValues& pair = valuesOf(row, kUndefined, table);
    if (row.evaluated()) pair.values.push_back(value);
  }
  return table;
}

RunTable pairTableOf(const RecordedRun& run, double tau, double Metrics::*metric) {
  RunTable table;
  std::set<double> taus;
  for (const ResultRow& row : run.rows) {
    for (const Metrics& metrics : row.metrics) {
      if (!std::isnan(metrics.tau)) taus.insert(metrics.tau);
    }
    const Metrics* const metrics = row.metricsAt(tau);
    if (metrics == nullptr) continue;
    PairValues& pair = valuesOf(row, metrics->tau, table);
    if (!row.evaluated()) continue;
    if (!std::isnan(metrics->*metric)) pair.values.push_back(metrics->*metric);
    if (!std::isnan(row.select_seconds)) pair.seconds.push_back(row.select_seconds);
  }
  if (!taus.empty() && taus.count(tau) == 0) {
    std::vector<std::string> texts;
    for (const double known : taus) texts.push_back(formatNumber(known));
    throw std::invalid_argument(run.folder + " has no counts at tau = " + formatNumber(tau) +
                                " px; give one of its tolerances: " + joinList(texts));
  }
  return table;
}

RunTable tableOf(const RecordedRun& run, const ComparisonOptions& options) {
  for (const auto& [name, metric] : kPoseMetrics) {
    if (options.metric == name) return poseTableOf(run, metric);
  }
  for (const auto& [name, metric] : kMetrics) {
    if (options.metric == name) return pairTableOf(run, options.tau, metric);
  }
  throw std::logic_error("metric '" + options.metric + "' was not checked");
}

UnmatchedValue unmatched(const GroupKey& key, const std::string& pair, const std::string& reason) {
  return {std::get<0>(key), std::get<1>(key), std::get<2>(key), std::get<3>(key), pair, reason};
}

/// Values of `one` that `other` lacks.
std::vector<UnmatchedValue> missingIn(const RunTable& other, const RunTable& one) {
  std::vector<UnmatchedValue> missing;
  for (const GroupKey& key : one.order) {
    const auto group = other.groups.find(key);
    if (group == other.groups.end()) {
      missing.push_back(unmatched(key, "", "no rows of this group"));
      continue;
    }
    for (const auto& [pair, values] : one.groups.at(key)) {
      const std::string name = pair.first + "/" + pair.second;
      const auto found = group->second.find(pair);
      if (found == group->second.end()) {
        missing.push_back(unmatched(key, name, "no row"));
      } else if (!values.values.empty() && found->second.values.empty()) {
        missing.push_back(unmatched(key, name, "no value (status " + toString(found->second.status) + ")"));
      }
    }
  }
  return missing;
}

Verdict verdictOf(const std::vector<double>& differences, const GroupComparison& group, double tolerance) {
  if (std::all_of(differences.begin(), differences.end(), [](double d) { return d == 0; })) {
    return Verdict::kEqual;
  }
  if (group.interval.low <= 0 && group.interval.high >= 0) return Verdict::kWithinNoise;
  if (std::abs(group.difference) <= tolerance) return Verdict::kWithinTolerance;
  return group.difference > 0 ? Verdict::kBetter : Verdict::kWorse;
}

std::string textOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in) {
    throw RunFolderError("cannot read " + file.string() +
                         ": give the output folder of a run, which holds config.yaml and pairs.csv");
  }
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void requireYaml(const RecordedRun& run) {
  try {
    yamlDifferences(run.config, "");
  } catch (const std::invalid_argument& error) {
    throw RunFolderError(run.folder + "/config.yaml is damaged (" + error.what() +
                         "): repair it, or run the benchmark again into another folder");
  }
}

}  // namespace

RecordedRun readRun(const std::string& folder) {
  RecordedRun run;
  run.folder = folder;
  run.config = textOf(std::filesystem::path(folder) / "config.yaml");
  requireYaml(run);
  run.rows = readResults(folder);
  run.poses = readPoses(folder);
  return run;
}

std::vector<std::string> comparisonMetrics() {
  std::vector<std::string> names;
  for (const auto& metric : kMetrics) names.emplace_back(metric.first);
  for (const auto& metric : kPoseMetrics) names.emplace_back(metric.first);
  return names;
}

bool hasTolerances(const std::string& metric) {
  return std::any_of(std::begin(kMetrics), std::end(kMetrics),
                     [&metric](const auto& known) { return metric == known.first; });
}

std::string toString(Verdict verdict) {
  switch (verdict) {
    case Verdict::kEqual:
      return "equal";
    case Verdict::kWithinNoise:
      return "within noise";
    case Verdict::kWithinTolerance:
      return "within tolerance";
    case Verdict::kBetter:
      return "better";
    case Verdict::kWorse:
      return "worse";
  }
  throw std::invalid_argument("unknown verdict " + std::to_string(static_cast<int>(verdict)));
}

std::string UnmatchedValue::text() const {
  return dataset + ", " + features + ", preselection " + preselection + ", " + selector + ": " +
         (pair.empty() ? "" : pair + ": ") + reason;
}

std::size_t RunComparison::count(Verdict verdict) const {
  return static_cast<std::size_t>(std::count_if(
      groups.begin(), groups.end(), [verdict](const GroupComparison& g) { return g.verdict == verdict; }));
}

double RunComparison::expectedByChance() const {
  return 0.05 * static_cast<double>(groups.size() - count(Verdict::kEqual));
}

bool RunComparison::passes(bool strict) const {
  if (count(Verdict::kWorse) > 0 || !lost.empty()) return false;
  return !strict ||
         (added.empty() && std::none_of(groups.begin(), groups.end(),
                                        [](const GroupComparison& g) { return g.beyond_tolerance; }));
}

RunComparison compareRuns(const RecordedRun& before, const RecordedRun& after,
                          const ComparisonOptions& options) {
  requireMetric(options.metric);
  if (!(options.tolerance >= 0 && options.tolerance <= 1)) {
    throw std::invalid_argument("tolerance = " + formatNumber(options.tolerance) + " is outside [0, 1]");
  }
  if (options.resamples < 1) {
    throw std::invalid_argument("resamples = " + std::to_string(options.resamples) + " is below 1");
  }
  requireYaml(before);
  requireYaml(after);
  const RunTable old_table = tableOf(before, options), new_table = tableOf(after, options);
  RunComparison result;
  result.config_differences = yamlDifferences(before.config, after.config);
  result.lost = missingIn(new_table, old_table);
  result.added = missingIn(old_table, new_table);
  for (const GroupKey& key : old_table.order) {
    const auto other = new_table.groups.find(key);
    if (other == new_table.groups.end()) continue;
    std::vector<double> old_values, new_values, differences, old_seconds, new_seconds;
    for (const auto& [pair, values] : old_table.groups.at(key)) {
      const auto found = other->second.find(pair);
      if (found == other->second.end() || values.values.empty() || found->second.values.empty()) continue;
      old_values.push_back(mean(values.values));
      new_values.push_back(mean(found->second.values));
      differences.push_back(new_values.back() - old_values.back());
      if (values.seconds.empty() || found->second.seconds.empty()) continue;
      old_seconds.push_back(mean(values.seconds));
      new_seconds.push_back(mean(found->second.seconds));
    }
    if (differences.empty()) continue;
    GroupComparison group;
    std::tie(group.dataset, group.features, group.preselection, group.selector) = key;
    group.tau = old_table.tau.at(key);
    group.pairs = differences.size();
    group.before = mean(old_values);
    group.after = mean(new_values);
    group.difference = mean(differences);
    group.interval = bootstrapMean(differences, options.seed, options.resamples);
    group.verdict = verdictOf(differences, group, options.tolerance);
    group.beyond_tolerance = std::abs(group.difference) > options.tolerance;
    group.time_ratio = quantile(new_seconds, 0.5) / quantile(old_seconds, 0.5);
    result.groups.push_back(group);
  }
  return result;
}

}  // namespace corrsel::core
