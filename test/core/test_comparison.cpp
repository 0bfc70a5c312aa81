#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/text.h"
#include "corrsel/benchmark/comparison.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/random.h"
#include "result_rows.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

namespace fs = std::filesystem;

constexpr std::size_t kPutative = 2000, kInliers = 1000;

/// A row whose numbers agree: as many selected as there are inliers, so that precision = recall = F.
ResultRow rowOf(const std::string& selector, const std::string& pair, std::size_t correct, double tau = 5) {
  ResultRow row;
  row.id = {"set", "scene", pair};
  row.features = "orb+orb";
  row.preselection = "none";
  row.selector = selector;
  row.truth = std::isnan(tau) ? TruthKind::kLabels : TruthKind::kHomography;
  row.n_putative = kPutative;
  row.n_ground_truth = row.n_selected = kInliers;
  row.metrics = {metricsOf(tau, correct, kInliers, kInliers, kInliers)};
  row.select_seconds = 0.002;
  return row;
}

/// One selector on as many pairs as there are counts.
RecordedRun runOf(const std::vector<std::size_t>& correct, const std::string& selector = "gms") {
  RecordedRun run;
  run.folder = "folder";
  run.config = "seed: 0\n";
  for (std::size_t i = 0; i < correct.size(); ++i) {
    run.rows.push_back(rowOf(selector, "1-" + std::to_string(i), correct[i]));
  }
  return run;
}

std::vector<std::size_t> randomCounts(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::size_t> counts(n);
  for (std::size_t& count : counts) count = 300 + random.index(500);
  return counts;
}

GroupComparison onlyGroup(const RunComparison& comparison) {
  EXPECT_EQ(comparison.groups.size(), 1U);
  return comparison.groups.empty() ? GroupComparison() : comparison.groups.front();
}

TEST(Comparison, EqualRuns) {
  const RecordedRun run = runOf(randomCounts(30, 1));
  const RunComparison comparison = compareRuns(run, run);
  const GroupComparison group = onlyGroup(comparison);
  EXPECT_EQ(group.verdict, Verdict::kEqual);
  EXPECT_EQ(group.pairs, 30U);
  EXPECT_EQ(group.difference, 0);
  EXPECT_EQ(group.time_ratio, 1);
  EXPECT_EQ(comparison.expectedByChance(), 0);
  EXPECT_TRUE(comparison.passes(false) && comparison.passes(true));
}

TEST(Comparison, OppositeDirectionsAreOppositeVerdicts) {
  std::vector<std::size_t> counts = randomCounts(30, 2), fewer = counts;
  Random random(3);
  for (std::size_t& count : fewer) count -= 20 + random.index(40);
  const RunComparison worse = compareRuns(runOf(counts), runOf(fewer)),
                      better = compareRuns(runOf(fewer), runOf(counts));
  const GroupComparison group = onlyGroup(worse), reversed = onlyGroup(better);
  EXPECT_EQ(group.verdict, Verdict::kWorse);
  EXPECT_NEAR(group.after - group.before, group.difference, 1e-12);
  EXPECT_LT(group.interval.low, group.difference);
  EXPECT_LT(group.difference, group.interval.high);
  EXPECT_LT(group.interval.high, 0);
  EXPECT_FALSE(worse.passes(false) || worse.passes(true));
  EXPECT_NEAR(worse.expectedByChance(), 0.05, 1e-12);
  EXPECT_EQ(reversed.verdict, Verdict::kBetter);
  EXPECT_NEAR(reversed.difference, -group.difference, 1e-12);
  // A change for the better fails only where every change does.
  EXPECT_TRUE(better.passes(false));
  EXPECT_FALSE(better.passes(true));
}

TEST(Comparison, NoiseIsNoVerdictUnlessStrict) {
  // One pair loses a lot, the rest a little to both sides: resamples without that pair show nothing.
  std::vector<std::size_t> before = randomCounts(20, 4), after = before;
  for (std::size_t i = 0; i < after.size(); ++i) after[i] += i % 2 ? 3 : -3;
  after[7] -= 200;
  const RunComparison comparison = compareRuns(runOf(before), runOf(after));
  EXPECT_EQ(onlyGroup(comparison).verdict, Verdict::kWithinNoise);
  EXPECT_TRUE(onlyGroup(comparison).beyond_tolerance);
  EXPECT_TRUE(comparison.passes(false));
  EXPECT_FALSE(comparison.passes(true));
}

TEST(Comparison, SmallCertainChangesAreWithinTolerance) {
  std::vector<std::size_t> before = randomCounts(20, 5), after = before;
  for (std::size_t& count : after) count -= 2;
  ComparisonOptions options;
  // Not 0.002 itself: the numbers are not exact.
  options.tolerance = 0.0021;
  RunComparison comparison = compareRuns(runOf(before), runOf(after), options);
  EXPECT_EQ(onlyGroup(comparison).verdict, Verdict::kWithinTolerance);
  EXPECT_TRUE(comparison.passes(true));
  options.tolerance = 0.0019;
  comparison = compareRuns(runOf(before), runOf(after), options);
  EXPECT_EQ(onlyGroup(comparison).verdict, Verdict::kWorse);
  EXPECT_FALSE(comparison.passes(false));
}

TEST(Comparison, MetricsOfPoses) {
  RecordedRun before = runOf(randomCounts(8, 1)), after = before;
  for (int i = 0; i < 8; ++i) {
    for (RecordedRun* run : {&before, &after}) {
      PoseRow row = testing::posesOf("1-" + std::to_string(i), run == &before ? 1.5 : 3.5 + 0.1 * i).front();
      row.epipolar_precision = kUndefined;
      run->poses.push_back(row);
    }
  }
  ComparisonOptions options;
  options.metric = "pose_maa";
  const GroupComparison group = onlyGroup(compareRuns(before, after, options));
  EXPECT_EQ(group.selector, "gms");
  EXPECT_EQ(group.pairs, 8U);
  EXPECT_TRUE(std::isnan(group.tau));
  EXPECT_FALSE(hasTolerances("pose_maa"));
  EXPECT_TRUE(hasTolerances("f_paper"));
  EXPECT_NEAR(group.before, 0.9, 1e-12);
  EXPECT_NEAR(group.after, (5 * 0.7 + 3 * 0.6) / 8, 1e-12);  // from 4.0 on, one threshold more is missed
  EXPECT_EQ(group.verdict, Verdict::kWorse);
  options.metric = "epipolar_precision";
  EXPECT_TRUE(compareRuns(before, after, options).groups.empty());
  options.metric = "corner_maa";
  EXPECT_TRUE(compareRuns(before, after, options).groups.empty());
}

TEST(Comparison, FalseAlarmsAreAsRareAsPromised) {
  // Two runs of the same distribution: about 5 % of the groups are called better or worse.
  RecordedRun before, after;
  before.config = after.config = "a: 1\n";
  Random random(6);
  const int n_groups = 400;
  for (int group = 0; group < n_groups; ++group) {
    for (int pair = 0; pair < 40; ++pair) {
      const std::string selector = "s" + std::to_string(group), name = std::to_string(pair);
      const std::size_t base = 300 + random.index(400);
      before.rows.push_back(rowOf(selector, name, base + random.index(60)));
      after.rows.push_back(rowOf(selector, name, base + random.index(60)));
    }
  }
  ComparisonOptions options;
  options.tolerance = 0;
  options.resamples = 1000;
  const RunComparison comparison = compareRuns(before, after, options);
  const double changed =
      static_cast<double>(comparison.count(Verdict::kBetter) + comparison.count(Verdict::kWorse));
  EXPECT_NEAR(comparison.expectedByChance(), 20, 1e-9);
  // Standard deviation of the count: 4.4.
  EXPECT_GT(changed, 7);
  EXPECT_LT(changed, 36);
}

TEST(Comparison, PairsAreJoinedByNameNotByPlace) {
  RecordedRun before = runOf(randomCounts(25, 7)), after = before;
  std::reverse(after.rows.begin(), after.rows.end());
  const RunComparison comparison = compareRuns(before, after);
  EXPECT_EQ(onlyGroup(comparison).verdict, Verdict::kEqual);
  EXPECT_TRUE(comparison.passes(true));
}

TEST(Comparison, RepetitionsAreAveraged) {
  RecordedRun before = runOf({500, 600}), after = runOf({500, 600});
  ResultRow again = rowOf("gms", "1-0", 700);
  again.seed = 1;
  after.rows.push_back(again);
  const GroupComparison group = onlyGroup(compareRuns(before, after));
  EXPECT_EQ(group.pairs, 2U);
  EXPECT_NEAR(group.difference, 0.05, 1e-12);
}

TEST(Comparison, OnlyTheToleranceAndLabelledRowsCount) {
  RecordedRun before = runOf(randomCounts(8, 8)), after = before;
  before.rows.push_back(rowOf("gms", "1-0", 900, 10));
  after.rows.push_back(rowOf("gms", "1-0", 100, 10));
  EXPECT_EQ(onlyGroup(compareRuns(before, after)).verdict, Verdict::kEqual);
  for (int pair = 0; pair < 8; ++pair) {
    for (RecordedRun* run : {&before, &after}) {
      run->rows.push_back(rowOf("gms", std::to_string(pair), run == &before ? 900 : 800, kUndefined));
      run->rows.back().id.dataset = "labelled";
    }
  }
  const RunComparison comparison = compareRuns(before, after);
  ASSERT_EQ(comparison.groups.size(), 2U);
  EXPECT_EQ(comparison.groups[0].tau, 5);
  EXPECT_TRUE(std::isnan(comparison.groups[1].tau));
  EXPECT_EQ(comparison.groups[1].verdict, Verdict::kWorse);
  // The other tolerance has another result; a tolerance that no run has is refused.
  ComparisonOptions options;
  options.tau = 10;
  EXPECT_NE(compareRuns(before, after, options).groups[0].verdict, Verdict::kEqual);
  options.tau = 7;
  const std::string error = errorOf<std::invalid_argument>([&] { compareRuns(before, after, options); });
  EXPECT_TRUE(contains(error, "tau = 7 px") && contains(error, "5, 10")) << error;
}

TEST(Comparison, EveryMetricIsCompared) {
  RecordedRun before = runOf(randomCounts(10, 9));
  const std::vector<double Metrics::*> members = {&Metrics::f_paper, &Metrics::f_same_tau,
                                                  &Metrics::precision, &Metrics::recall_paper,
                                                  &Metrics::recall_same_tau};
  ASSERT_EQ(comparisonMetrics().size(), members.size() + 3);  // three are those of poses
  for (std::size_t i = 0; i < members.size(); ++i) {
    RecordedRun after = before;
    for (ResultRow& row : after.rows) row.metrics[0].*members[i] -= 0.1;
    for (std::size_t k = 0; k < members.size(); ++k) {
      ComparisonOptions options;
      options.metric = comparisonMetrics()[k];
      EXPECT_EQ(onlyGroup(compareRuns(before, after, options)).verdict,
                i == k ? Verdict::kWorse : Verdict::kEqual)
          << options.metric;
    }
  }
}

TEST(Comparison, WhatOnlyOneRunHas) {
  RecordedRun before = runOf(randomCounts(8, 10)), after = before;
  after.rows.erase(after.rows.begin() + 2);
  after.rows[0].status = Status::kFailed;
  RunComparison comparison = compareRuns(before, after);
  ASSERT_EQ(comparison.lost.size(), 2U);
  EXPECT_EQ(comparison.lost[0].text(),
            "set, orb+orb, preselection none, gms: scene/1-0: no value (status failed)");
  EXPECT_EQ(comparison.lost[1].text(), "set, orb+orb, preselection none, gms: scene/1-2: no row");
  EXPECT_EQ(onlyGroup(comparison).pairs, 6U);
  EXPECT_EQ(onlyGroup(comparison).verdict, Verdict::kEqual);
  EXPECT_FALSE(comparison.passes(false));
  comparison = compareRuns(after, before);
  EXPECT_TRUE(comparison.lost.empty());
  EXPECT_EQ(comparison.added.size(), 2U);
  EXPECT_TRUE(comparison.passes(false));
  EXPECT_FALSE(comparison.passes(true));

  // A whole group is named once.
  after = runOf(randomCounts(8, 10), "lpm");
  comparison = compareRuns(before, after);
  ASSERT_EQ(comparison.lost.size(), 1U);
  EXPECT_EQ(comparison.lost[0].text(), "set, orb+orb, preselection none, gms: no rows of this group");
  EXPECT_EQ(comparison.added.size(), 1U);
  EXPECT_TRUE(comparison.groups.empty());
}

TEST(Comparison, PairsWithoutValueInBothDoNotCount) {
  RecordedRun before = runOf({500, 600, 700}), after = before;
  for (RecordedRun* run : {&before, &after}) {
    run->rows[0].status = Status::kUnsupportedInput;
    run->rows[1].metrics[0].f_paper = kUndefined;
  }
  const RunComparison comparison = compareRuns(before, after);
  EXPECT_EQ(onlyGroup(comparison).pairs, 1U);
  EXPECT_TRUE(comparison.passes(true));
  EXPECT_TRUE(compareRuns(runOf({}), runOf({})).passes(true));
}

TEST(Comparison, TimesAndConfigurationAreInformation) {
  RecordedRun before = runOf(randomCounts(9, 12)), after = before;
  for (ResultRow& row : after.rows) row.select_seconds = 0.006;
  after.config = "seed: 4\n";
  const RunComparison comparison = compareRuns(before, after);
  EXPECT_NEAR(onlyGroup(comparison).time_ratio, 3, 1e-12);
  EXPECT_EQ(comparison.config_differences, std::vector<std::string>{"seed: '0' -> '4'"});
  EXPECT_TRUE(comparison.passes(true));
  for (ResultRow& row : after.rows) row.select_seconds = kUndefined;
  EXPECT_TRUE(std::isnan(onlyGroup(compareRuns(before, after)).time_ratio));
}

TEST(Comparison, BadOptionsAreNamed) {
  const RecordedRun run = runOf({500});
  ComparisonOptions options;
  options.metric = "f";
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { compareRuns(run, run, options); }),
                       "unknown metric 'f'; valid: f_paper"));
  options = {};
  options.tolerance = -1;
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { compareRuns(run, run, options); }),
                       "tolerance = -1 is outside [0, 1]"));
  options = {};
  options.resamples = 0;
  EXPECT_TRUE(contains(errorOf<std::invalid_argument>([&] { compareRuns(run, run, options); }), "resamples"));
}

/// A run folder on disk, to be damaged.
class RecordedFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("corrsel_comparison_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
    BenchmarkConfig config;
    config.bags = {"a.bag"};
    config.features = {"orb+orb"};
    config.tolerances = {5};
    config.resolve();
    RunFolder folder(folder_.string(), config, false);
    folder.appendPair({rowOf("gms", "1-2", 700), rowOf("gms", "1-3", 0)}, 0, {});
    ResultRow none = rowOf("gms", "1-4", 0);
    none.n_selected = 0;
    none.metrics = {metricsOf(5, 0, kInliers, 0, kInliers)};
    ResultRow hopeless = none;
    hopeless.id.pair = "1-5";
    hopeless.n_ground_truth = 0;
    hopeless.metrics = {metricsOf(5, 0, 0, 0, 0)};
    ResultRow unsupported = rowOf("gms", "1-6", 100);
    unsupported.status = Status::kUnsupportedInput;
    folder.appendPair({none, hopeless, unsupported}, 0, {});
    std::ifstream in(folder_ / "pairs.csv");
    for (std::string line; std::getline(in, line);) lines_.push_back(line);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const std::vector<std::string>& lines, const std::string& end = "\n") {
    std::ofstream(folder_ / "pairs.csv") << joinList(lines, "\n") << end;
  }

  /// Returns the error about the folder after a field of a line (both from 1) has been replaced.
  std::string errorWith(std::size_t line, std::size_t field, const std::string& text) {
    std::vector<std::string> lines = lines_, fields = parseCsvLine(lines[line - 1]);
    fields[field - 1] = text;
    lines[line - 1] = joinList(fields, ",");
    write(lines);
    return errorOf<RunFolderError>([&] { readResults(folder_.string()); });
  }

  fs::path folder_;
  std::vector<std::string> lines_;
};

TEST_F(RecordedFolder, IsReadBack) {
  const RecordedRun run = readRun(folder_.string());
  EXPECT_EQ(run.rows.size(), 5U);
  EXPECT_EQ(run.rows[0].metrics[0].n_correct, 700U);
  EXPECT_EQ(run.rows[0].metrics[0].f_paper, 0.7);
  EXPECT_TRUE(contains(run.config, "tolerances"));
  EXPECT_TRUE(compareRuns(run, run).passes(true));
}

TEST_F(RecordedFolder, EditedNumbersAreFound) {
  struct Case {
    std::size_t line, field;
    const char *text, *part;
  };
  const std::vector<Case> cases = {
      {3, 7, "guess", "truth: 'guess'"},
      {3, 7, "labels", "n_inliers_5px = 1000 beside the truth labels"},
      {3, 7, "none", "n_inliers_5px = 1000 beside the truth none"},
      {3, 10, "900", "n_ground_truth = 1000 exceeds n_putative = 900"},
      {3, 12, "2001", "n_inliers_5px = 2001 exceeds n_putative = 2000"},
      {3, 12, "600", "n_correct_5px = 700 exceeds n_inliers_5px = 600"},
      {3, 13, "2001", "n_selected = 2001 exceeds n_putative = 2000"},
      {3, 13, "600", "n_correct_5px = 700 exceeds n_selected = 600"},
      {3, 14, "7", "n_correct_labels = 7 beside the truth homography"},
      {3, 15, "-1", "'-1' is not a count"},
      {3, 15, "0.5", "'0.5' is not a count"},
      {3, 15, "", "n_correct_5px is missing"},
      {3, 16, "fine", "unknown status 'fine'"},
      {3, 18, "x", "confidence"},
      {3, 19, "x", "seed"},
      {3, 23, "-0.1", "select_s = -0.1 is no time"},
      {7, 13, "5", "status unsupported_input beside numbers"},
      {7, 15, "5", "status unsupported_input beside n_correct_5px"},
  };
  for (const Case& c : cases) {
    const std::string error = errorWith(c.line, c.field, c.text);
    EXPECT_TRUE(contains(error, (folder_ / "pairs.csv").string() + ", line " + std::to_string(c.line) + ":"))
        << c.text << ": " << error;
    EXPECT_TRUE(contains(error, c.part)) << c.part << ": " << error;
    EXPECT_TRUE(contains(error, "another folder")) << error;
  }
}

TEST_F(RecordedFolder, FormatsOfOtherVersionsAreNamedWithTheRemedy) {
  const auto error = [this] { return errorOf<RunFolderError>([this] { readRun(folder_.string()); }); };
  for (const auto& [first, found] :
       {std::pair{"dataset,sequence,pair,features,preselection,selector,tau_px", "format 1"},
        std::pair{"# corrsel pairs 3", "format 3"}}) {
    std::vector<std::string> lines = lines_;
    lines.front() = first;
    write(lines);
    EXPECT_TRUE(contains(error(), found) && contains(error(), "reads format 2")) << error();
    EXPECT_TRUE(contains(error(), "config.yaml") && contains(error(), "environment.json")) << error();
  }
}

TEST_F(RecordedFolder, BrokenFilesAreFound) {
  const auto error = [this] { return errorOf<RunFolderError>([this] { readRun(folder_.string()); }); };
  std::vector<std::string> lines = lines_;
  lines[3] = lines[3].substr(0, 30);
  write(lines);
  EXPECT_TRUE(contains(error(), "line 4: row has")) << error();
  lines = lines_;
  lines.push_back(lines[2]);
  write(lines);
  EXPECT_TRUE(contains(error(), "line 8: repeats the selection of line 3")) << error();
  write(lines_, "");
  EXPECT_TRUE(contains(error(), "line 7: the line is cut off")) << error();
  lines = lines_;
  lines[1] = "a,b";
  write(lines);
  EXPECT_TRUE(contains(error(), "line 2: ") && contains(error(), "header")) << error();
  lines.front() = "a,b";
  write(lines);
  EXPECT_TRUE(contains(error(), "line 1: ") && contains(error(), "no file of a benchmark run")) << error();
  std::ofstream(folder_ / "pairs.csv").close();
  EXPECT_TRUE(contains(error(), "line 1: ")) << error();
  fs::remove(folder_ / "pairs.csv");
  EXPECT_TRUE(contains(error(), "pairs.csv does not exist")) << error();
  std::ofstream(folder_ / "config.yaml") << "a: [1, 2\n";
  EXPECT_TRUE(contains(error(), "config.yaml is damaged")) << error();
  fs::remove_all(folder_);
  EXPECT_TRUE(contains(error(), "config.yaml") && contains(error(), "output folder")) << error();
}

}  // namespace
}  // namespace corrsel::core
