#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/benchmark/results.h"
#include "corrsel/evaluation/statistics.h"

namespace corrsel::core {

/// The part of a run's results that a comparison needs.
struct RecordedRun {
  std::string folder;
  std::string config;  ///< text of config.yaml
  std::vector<ResultRow> rows;
};

/// Throws RunFolderError if a file is missing or damaged, naming the line and the remedy.
RecordedRun readRun(const std::string& folder);

/// Columns of pairs.csv that can be compared; all of them are better when higher.
std::vector<std::string> comparisonMetrics();

struct ComparisonOptions {
  double tau = 5.0;  ///< px; labelled rows are always compared
  std::string metric = "f_paper";
  double tolerance = 0.002;             ///< mean differences up to this do not matter, in units of the metric
  int resamples = kBootstrapResamples;  ///< of the bootstrap, at least 1
  std::uint64_t seed = kBootstrapSeed;  ///< of the bootstrap
};

enum class Verdict : std::uint8_t {
  kEqual,            ///< every pair has the same value in both runs
  kWithinNoise,      ///< the 95 % interval of the mean difference contains 0
  kWithinTolerance,  ///< it does not, but the mean difference is at most the tolerance
  kBetter,
  kWorse
};

std::string toString(Verdict verdict);

/// With fewer pairs than this the bootstrap interval is too narrow: with five differences of one sign, a sign
/// test (two-sided, 5 %) does not reject chance.
inline constexpr std::size_t kFewPairs = 6;

/// One selector on one dataset with one kind of matches, in both runs.
struct GroupComparison {
  std::string dataset, features, preselection, selector;
  double tau = kUndefined;                         ///< px; NaN for labelled truth
  std::size_t pairs = 0;                           ///< pairs with a value in both runs
  double before = kUndefined, after = kUndefined;  ///< means over these pairs
  double difference = kUndefined;                  ///< mean of after - before
  Interval interval = {kUndefined, kUndefined};    ///< 95 %, of the difference
  Verdict verdict = Verdict::kEqual;
  /// Median selection time after / before; NaN if a run has no times. No verdict uses it.
  double time_ratio = kUndefined;

  /// Returns whether the mean moved by more than the tolerance, by chance or not.
  bool beyond_tolerance = false;
};

/// A value that only one of the runs has.
struct UnmatchedValue {
  std::string dataset, features, preselection, selector;
  std::string pair;    ///< "sequence/pair"; empty: the whole group
  std::string reason;  ///< why the other run has none

  /// "dataset, features, preselection none, selector: sequence/pair: reason".
  std::string text() const;
};

struct RunComparison {
  std::vector<GroupComparison> groups;          ///< in the order of BEFORE's rows
  std::vector<UnmatchedValue> lost, added;      ///< missing in AFTER; missing in BEFORE
  std::vector<std::string> config_differences;  ///< "key: old -> new"

  std::size_t count(Verdict verdict) const;

  /// Expected number of groups that are called better or worse if the runs differ by chance alone: 5 % of
  /// those that differ at all. Each verdict is for its group and not corrected for the number of groups.
  double expectedByChance() const;

  /// Returns whether nothing became worse and AFTER has every value of BEFORE.
  /// @param strict  require also that no mean moved by more than the tolerance in either direction, by chance
  /// or not,
  ///                and that BEFORE has every value of AFTER. Meant for deterministic runs of the same pairs.
  bool passes(bool strict) const;
};

/// Joins the runs by dataset, features, preselection, selector and pair, averages repetitions, and compares
/// each group by a paired bootstrap of the mean difference (Efron 1979), see bootstrapMean(). Throws
/// std::invalid_argument for an unknown metric, an option out of range, or a run that has rows with
/// tolerances but none with `tau`, and RunFolderError if a config.yaml is not YAML. O(rows log rows + groups
/// * resamples * pairs).
RunComparison compareRuns(const RecordedRun& before, const RecordedRun& after,
                          const ComparisonOptions& options = {});

}  // namespace corrsel::core
