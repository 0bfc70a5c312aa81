#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/benchmark/results.h"
#include "corrsel/evaluation/statistics.h"

namespace corrsel::core {

/// The results of a run that a comparison needs.
struct RecordedRun {
  std::string folder;
  std::string config;  ///< text of config.yaml
  std::vector<ResultRow> rows;
  std::vector<PoseRow> poses;
};

/// Reads a run folder. Throws RunFolderError where a file is missing or damaged; the text names the file, the
/// line and the remedy.
RecordedRun readRun(const std::string& folder);

/// Columns of pairs.csv that can be compared; of poses.csv epipolar_precision, and pose_maa and corner_maa,
/// the thresholdAccuracy() of the errors. All of them are better when higher.
std::vector<std::string> comparisonMetrics();

/// Whether a metric is one of pairs.csv, which has rows of several tolerances.
bool hasTolerances(const std::string& metric);

struct ComparisonOptions {
  double tau = 5.0;  ///< px; labelled rows and those of poses.csv, which have none, are always compared
  std::string metric = "f_paper";
  double tolerance = 0.002;             ///< mean differences up to this are ignored, in units of the metric
  int resamples = kBootstrapResamples;  ///< of the bootstrap, at least 1
  std::uint64_t seed = kBootstrapSeed;  ///< of the bootstrap
};

enum class Verdict : std::uint8_t {
  kEqual,            ///< every pair has the same value in both runs
  kWithinNoise,      ///< the 95 % interval of the mean difference contains 0
  kWithinTolerance,  ///< the interval leaves out 0, but the mean difference is at most the tolerance
  kBetter,
  kWorse
};

std::string toString(Verdict verdict);

/// Below this many pairs the bootstrap interval is too narrow: for five differences of one sign, a two-sided
/// sign test at 5 % would not reject the hypothesis that they are due to chance.
inline constexpr std::size_t kFewPairs = 6;

/// The comparison of one selector on one dataset with one kind of features and preselection.
struct GroupComparison {
  std::string dataset, features, preselection, selector;
  double tau = kUndefined;                         ///< px; NaN for labelled truth
  std::size_t pairs = 0;                           ///< pairs with a value in both runs
  double before = kUndefined, after = kUndefined;  ///< means over these pairs
  double difference = kUndefined;                  ///< mean of after - before
  Interval interval = {kUndefined, kUndefined};    ///< 95 %, of the difference
  Verdict verdict = Verdict::kEqual;
  /// Median selection time after / before; NaN where a run has no times. No verdict uses it.
  double time_ratio = kUndefined;

  /// Whether the mean moved by more than the tolerance, significantly or not.
  bool beyond_tolerance = false;
};

/// A value that only one of the runs has.
struct UnmatchedValue {
  std::string dataset, features, preselection, selector;
  std::string pair;    ///< "sequence/pair"; empty where the whole group is missing
  std::string reason;  ///< why the other run has no value

  /// "dataset, features, preselection none, selector: sequence/pair: reason".
  std::string text() const;
};

struct RunComparison {
  std::vector<GroupComparison> groups;          ///< in the order of BEFORE's rows
  std::vector<UnmatchedValue> lost, added;      ///< missing in AFTER; missing in BEFORE
  std::vector<std::string> config_differences;  ///< "key: old -> new"

  std::size_t count(Verdict verdict) const;

  /// Number of groups that would be called better or worse if the runs differed by chance alone: 5 % of the
  /// groups that differ at all. Each verdict holds for its group alone and is not corrected for their number.
  double expectedByChance() const;

  /// Whether nothing became worse and AFTER has every value of BEFORE.
  /// @param strict  whether to demand also that no mean moved by more than the tolerance in either direction,
  ///                significantly or not, and that BEFORE has every value of AFTER. This suits deterministic
  ///                runs of the same pairs, where every change has a cause.
  bool passes(bool strict) const;
};

/// Joins the runs by dataset, features, preselection, selector and pair, averages repetitions, and tests
/// each group by the bootstrap interval of the mean of the paired differences, see bootstrapMean(). Throws
/// std::invalid_argument for an unknown metric, an option out of range, or a run that has rows of tolerances
/// but none of `tau`. Throws RunFolderError where a config.yaml is not YAML. O(rows log rows + groups *
/// resamples * pairs).
RunComparison compareRuns(const RecordedRun& before, const RecordedRun& after,
                          const ComparisonOptions& options = {});

}  // namespace corrsel::core
