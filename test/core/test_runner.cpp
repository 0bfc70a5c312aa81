#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>

#include "base/text.h"
#include "benchmark/example_images.h"
#include "benchmark/tables.h"
#include "corrsel/benchmark/runner.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/random.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

// Every selector, and every one but nnsr after nnsr.
std::size_t selections() { return 2 * usualSelectorNames().size() - 1; }

using testing::contains;

namespace fs = std::filesystem;

/// Pairs made in memory: seeded blobs seen through a known homography; the pair numbered `broken` cannot be
/// read.
class MemorySource : public PairSource {
 public:
  explicit MemorySource(std::size_t size, std::size_t broken = 1000, bool inverted = false)
      : size_(size), broken_(broken), inverted_(inverted) {}
  std::size_t size() const override { return size_; }
  bool next(ImagePair& pair) override {
    if (at_ == size_) return false;
    const std::size_t number = at_++;
    pair = ImagePair();
    pair.id = {"memory", "scene", std::to_string(number)};
    if (number == broken_) throw DatasetError("picture " + std::to_string(number) + " is broken");
    Random random(number);
    pair.left = cv::Mat(240, 320, CV_8U, cv::Scalar(40));
    for (int k = 0; k < 150; ++k) {
      const auto y = static_cast<int>(random.index(240)), x = static_cast<int>(random.index(320));
      const cv::Scalar grey(random.uniform(60, 255));
      const int radius = 2 + static_cast<int>(random.index(9));
      cv::circle(pair.left, {x, y}, radius, grey, -1);
    }
    pair.truth.kind = TruthKind::kHomography;
    pair.truth.matrix = cv::Matx33d(0.95, 0.05, 6, -0.04, 0.97, 9, 1e-5, 0, 1);
    cv::warpPerspective(pair.left, pair.right, pair.truth.matrix, pair.left.size());
    if (inverted_) pair.truth.matrix = pair.truth.matrix.inv();
    return true;
  }

 private:
  std::size_t size_, broken_, at_ = 0;
  bool inverted_;
};

class Runner : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_runner_" + std::to_string(::getpid()));
    fs::remove_all(root_);
    config_.bags = {"memory"};
    config_.features = {"orb+orb", "sift+sift"};
    config_.selectors = {"all"};
    config_.tolerances = {2, 5};
    config_.resolve();
  }
  void TearDown() override { fs::remove_all(root_); }

  struct Outcome {
    RunState state;
    std::vector<std::string> rows;  // time columns taken out
  };

  static std::vector<std::unique_ptr<PairSource>> sources(std::size_t pairs, std::size_t broken = 1000) {
    std::vector<std::unique_ptr<PairSource>> list;
    list.push_back(std::make_unique<MemorySource>(pairs, broken));
    return list;
  }

  Outcome run(const std::string& name, std::size_t pairs, bool resume = false, std::size_t broken = 1000,
              std::size_t stop_after = 1000, const Shard& shard = {}) {
    struct Stopper : RunObserver {
      void progress(const Progress& progress) override { stop = stop || progress.done >= limit; }
      std::atomic<bool> stop{false};
      std::size_t limit = 0;
    } observer;
    observer.limit = stop_after;
    RunFolder folder((root_ / name).string(), config_, resume);
    Outcome outcome;
    outcome.state =
        BenchmarkRunner(config_, folder, observer, observer.stop).run(sources(pairs, broken), shard);
    writeSummary(folder, outcome.state);
    std::ifstream in(root_ / name / "pairs.csv");
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> fields = parseCsvLine(line);
      if (fields.size() < 2) continue;  // the format
      fields.resize(pairsTable(config_.tolerances).indexOf("detect_s"));
      outcome.rows.push_back(joinList(fields, ","));
    }
    return outcome;
  }

  fs::path root_;
  BenchmarkConfig config_;
};

TEST_F(Runner, WritesTheWholeGrid) {
  const Outcome outcome = run("run", 2);
  EXPECT_TRUE(outcome.state.complete());
  // Per pair: 2 features x selections().
  EXPECT_EQ(outcome.rows.size(), 1U + 2 * 2 * selections());
  const std::vector<SummaryRow> summary =
      writeSummary(RunFolder((root_ / "run").string(), config_, true), outcome.state);
  for (const SummaryRow& row : summary) {
    if (row.selector == "ransac" && row.features == "sift+sift" && row.tau == 5) {
      EXPECT_GT(row.f_paper, 0.8);
    }
    if (row.selector == "keep_all" && row.preselection == "none") {
      EXPECT_LT(row.precision, 0.95);
    }
  }
}

TEST_F(Runner, EveryDrawnPairIsDrawnForEverySelectorOnce) {
  run("drawn", 3);
  RunFolder folder((root_ / "drawn").string(), config_, true);
  const auto draw = [&] {
    RunObserver observer;
    const std::atomic<bool> stop{false};
    BenchmarkRunner(config_, folder, observer, stop).drawExamples(sources(3));
  };
  draw();
  const std::vector<ExampleImage> images = readExampleImages(folder.path());
  std::map<std::string, std::set<std::string>> selectors;  // by pair
  for (const ExampleImage& image : images) {
    selectors[image.id.text()].insert(image.selector);
    EXPECT_EQ(image.features, "orb+orb");
    EXPECT_EQ(image.preselection, "none");
    EXPECT_TRUE(fs::exists(root_ / "drawn" / "images" / image.file)) << image.file;
  }
  ASSERT_FALSE(selectors.empty());
  std::size_t pictures = 0;
  for (const auto& [pair, names] : selectors) {
    EXPECT_GE(names.size(), 8U) << pair;             // all but what cannot run on ORB
    EXPECT_EQ(names.count("keep_all"), 1U) << pair;  // the matches before selection
    pictures += names.size();
  }
  EXPECT_EQ(images.size(), pictures);
  const auto written = fs::last_write_time(root_ / "drawn" / "images" / images.front().file);
  draw();
  EXPECT_EQ(fs::last_write_time(root_ / "drawn" / "images" / images.front().file), written);
}

TEST_F(Runner, ShardsMergedEqualTheUncutRun) {
  const Outcome uncut = run("uncut", 5, false, 3);
  std::vector<std::string> parts;
  for (const char* part : {"1/2", "2/2"}) {
    parts.push_back("part" + std::string(part, 1));
    const Outcome outcome = run(parts.back(), 5, false, 3, 1000, Shard::fromText(part));
    EXPECT_EQ(outcome.state.shard, part);
    EXPECT_EQ(outcome.state.pairs_done + outcome.state.pairs_failed, outcome.state.pairs_total);
  }
  {
    RunFolder merged((root_ / "merged").string(), config_, false);
    for (const std::string& part : parts) mergeRun(merged, (root_ / part).string(), config_);
    EXPECT_EQ(merged.doneCount(), 4U);
  }
  const Outcome merged = run("merged", 5, true, 3);
  EXPECT_EQ(merged.rows, uncut.rows);
  EXPECT_EQ(merged.state.pairs_failed, 1U);
  EXPECT_EQ(merged.state.pairs_done, uncut.state.pairs_done);
}

/// The files below a folder, with their texts.
std::map<std::string, std::string> textsIn(const fs::path& folder) {
  std::map<std::string, std::string> texts;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file())
      texts[fs::relative(entry.path(), folder).string()] = readTextFile(entry.path().string());
  }
  return texts;
}

TEST_F(Runner, SavedMatchesAreThoseOfTheUncutRun) {
  config_.features = {"orb+orb"};
  config_.selectors = {"usac", "lpm:v2"};
  config_.repetitions = 2;
  config_.save_matches = true;
  config_.resolve();
  run("uncut", 3);
  const std::map<std::string, std::string> uncut = textsIn(root_ / "uncut" / "matches");
  // For every pair and preselection: usac, lpm:v2 and keep_all with two seeds; the putative ones.
  EXPECT_EQ(uncut.size(), 3U * 2 * (3 * 2 + 1) + 1);
  EXPECT_EQ(uncut.count("csv/memory/scene/0/orb+orb/none/lpm%3Av2@1.csv"), 1U);
  for (const ResultRow& row : readResults((root_ / "uncut").string())) {
    const std::string file = uniqueFileName(row.selector) + "@" + std::to_string(row.seed) + ".csv";
    const std::string& text = uncut.at("csv/memory/scene/" + row.id.pair + "/" + row.features + "/" +
                                       row.preselection + "/" + file);
    EXPECT_EQ(completeLines(text).size(), row.n_selected + 1) << file;
  }

  run("cut", 3, false, 1000, 1);
  run("cut", 3, true);
  EXPECT_EQ(textsIn(root_ / "cut" / "matches"), uncut);

  for (const char* part : {"1/2", "2/2"}) {
    const std::string name = "part" + std::string(part, 1);
    run(name, 3, false, 1000, 1000, Shard::fromText(part));
  }
  {
    RunFolder merged((root_ / "merged").string(), config_, false);
    for (const char* part : {"part1", "part2"}) mergeRun(merged, (root_ / part).string(), config_);
  }
  EXPECT_EQ(run("merged", 3, true).state.pairs_done, 3U);
  EXPECT_EQ(textsIn(root_ / "merged" / "matches"), uncut);
}

TEST_F(Runner, APairWithoutItsSavedMatchesIsRunAgain) {
  config_.features = {"orb+orb"};
  config_.selectors = {"usac"};
  config_.save_matches = true;
  config_.resolve();
  run("run", 2);
  const fs::path index = root_ / "run" / "matches" / "index.csv";
  const std::string text = readTextFile(index.string());
  std::ofstream(index) << text.substr(0, text.rfind("memory,scene,1"));
  EXPECT_EQ(RunFolder((root_ / "run").string(), config_, true).doneCount(), 1U);
  run("run", 2, true);
  EXPECT_EQ(readTextFile(index.string()), text);
}

TEST_F(Runner, MatchesAreSavedOnDemandOnly) {
  run("without", 1);
  EXPECT_FALSE(fs::exists(root_ / "without" / "matches"));
}

TEST_F(Runner, CornersAreMeasuredInTheExperimentsThatShowThem) {
  config_.features = {"orb+orb"};
  config_.preselection = {"none"};
  config_.selectors = {"gms", "keep_all"};
  run("without", 2);
  EXPECT_TRUE(readPoses((root_ / "without").string()).empty());
  for (const std::string section : {"pose", "budget"}) {
    config_.sections = {section};
    run(section, 2);
    const std::vector<PoseRow> rows = readPoses((root_ / section).string());
    ASSERT_EQ(rows.size(), 2U * 3) << section;
    EXPECT_EQ(rows[2].selector, kGroundTruthSelection);
    EXPECT_LT(rows[2].corner_error, 1);
    EXPECT_TRUE(std::isnan(rows[2].pose_error));
    EXPECT_EQ(RunFolder((root_ / section).string(), config_, true).doneCount(), 2U);
  }
}

/// The pairs of MemorySource, whose poses are given as well.
class PosedSource : public MemorySource {
 public:
  using MemorySource::MemorySource;
  bool next(ImagePair& pair) override {
    if (!MemorySource::next(pair)) return false;
    pair.truth.pose.emplace();
    pair.truth.pose->left_camera = pair.truth.pose->right_camera = {300, 0, 160, 0, 300, 120, 0, 0, 1};
    pair.truth.pose->translation = {1, 0, 0};
    return true;
  }
};

TEST_F(Runner, PosesAreMeasuredWhereTheyAreKnown) {
  config_.features = {"orb+orb"};
  config_.preselection = {"none"};
  config_.selectors = {"gms", "keep_all"};
  std::vector<std::unique_ptr<PairSource>> list;
  list.push_back(std::make_unique<PosedSource>(1));
  RunObserver observer;
  const std::atomic<bool> stop{false};
  RunFolder folder((root_ / "poses").string(), config_, false);
  BenchmarkRunner(config_, folder, observer, stop).run(list);
  const std::vector<PoseRow> rows = folder.readPoses();
  ASSERT_EQ(rows.size(), 3U);
  for (const PoseRow& row : rows) {
    EXPECT_GE(row.pose_error, 0) << row.selector;
    EXPECT_GE(row.epipolar_precision, 0) << row.selector;
    EXPECT_TRUE(std::isnan(row.corner_error)) << row.selector;
  }
}

TEST_F(Runner, CurvesNeedNoPoses) {
  config_.features = {"orb+orb"};
  config_.preselection = {"none"};
  config_.selectors = {"gms", "keep_all"};
  const auto posesWith = [&](const std::vector<std::string>& sections, const std::string& name) {
    config_.sections = sections;
    std::vector<std::unique_ptr<PairSource>> list;
    list.push_back(std::make_unique<PosedSource>(1));
    RunObserver observer;
    const std::atomic<bool> stop{false};
    RunFolder folder((root_ / name).string(), config_, false);
    BenchmarkRunner(config_, folder, observer, stop).run(list);
    const std::string stages = readTextFile((root_ / name / "stages.csv").string());
    EXPECT_EQ(stages.find(kPoseStage) == std::string::npos, folder.readPoses().empty()) << stages;
    EXPECT_EQ(RunFolder((root_ / name).string(), config_, true).doneCount(), 1U);
    return folder.readPoses().size();
  };
  EXPECT_EQ(posesWith({"curves"}, "curves"), 0U);
  EXPECT_EQ(posesWith({"curves", "pose"}, "both"), 3U);
  EXPECT_EQ(posesWith({"budget"}, "budget"), 3U);
}

TEST_F(Runner, CellsNeedNotBeAProduct) {
  config_.cells = {{"orb+orb", "none"}, {"orb+orb", "nnsr"}, {"sift+sift", "none"}};
  config_.resolve();
  const Outcome outcome = run("cells", 1);
  // Two cells without preselection; after nnsr, nnsr itself is left out.
  const std::size_t all = usualSelectorNames().size();
  EXPECT_EQ(outcome.rows.size(), 1U + (all + (all - 1) + all));
  EXPECT_EQ(run("cells", 1, true).state.pairs_done, 1U);
}

TEST_F(Runner, StagesOfEveryPairAreKept) {
  run("stages", 2);
  std::ifstream in(root_ / "stages" / "stages.csv");
  std::map<std::string, int> stages;
  for (std::string line; std::getline(in, line);) {
    const std::vector<std::string> fields = parseCsvLine(line);
    ASSERT_EQ(fields.size(), 6U);
    if (fields[0] == "number") continue;
    ++stages[fields[4]];
    EXPECT_GE(parseNumber(fields[5], "seconds"), 0.0) << line;
  }
  EXPECT_EQ(stages, (std::map<std::string, int>{
                        {"read", 2}, {"features", 2}, {"match", 2}, {"select", 2}, {"evaluate", 2}}));
}

TEST_F(Runner, ThreadsAndRunsDoNotChangeTheResults) {
  const Outcome first = run("first", 3), second = run("second", 3);
  config_.threads = 2;
  const Outcome threaded = run("threaded", 3);
  EXPECT_EQ(first.rows, second.rows);
  EXPECT_EQ(first.rows, threaded.rows);
}

TEST_F(Runner, InterruptedAndResumedEqualsUncut) {
  const Outcome uncut = run("uncut", 4);
  const Outcome cut = run("cut", 4, false, 1000, 2);
  EXPECT_TRUE(cut.state.interrupted);
  EXPECT_FALSE(cut.state.complete());
  EXPECT_LT(cut.rows.size(), uncut.rows.size());
  const Outcome resumed = run("cut", 4, true);
  EXPECT_TRUE(resumed.state.complete());
  EXPECT_EQ(resumed.state.pairs_done, 4U);
  EXPECT_EQ(resumed.rows, uncut.rows);
}

TEST_F(Runner, BrokenPairIsRecordedAndTheRunGoesOn) {
  const Outcome outcome = run("broken", 3, false, 1);
  EXPECT_EQ(outcome.state.pairs_done, 2U);
  EXPECT_EQ(outcome.state.pairs_failed, 1U);
  EXPECT_FALSE(outcome.state.complete());
  std::ifstream in(root_ / "broken" / "failures.csv");
  const std::string failures{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  EXPECT_TRUE(contains(failures, "memory,scene,1,,read,picture 1 is broken")) << failures;
  const Outcome mended = run("broken", 3, true);
  EXPECT_TRUE(mended.state.complete());
}

TEST_F(Runner, DoubtfulGroundTruthIsReported) {
  struct Listener : RunObserver {
    void doubtful(const TruthWarning& warning) override { texts.push_back(warning.text()); }
    std::vector<std::string> texts;
  };
  config_.selectors = {"lpm"};
  config_.resolve();
  const std::atomic<bool> stop{false};
  for (const bool inverted : {false, true}) {
    SCOPED_TRACE(inverted);
    Listener listener;
    RunFolder folder((root_ / (inverted ? "inverted" : "right")).string(), config_, false);
    std::vector<std::unique_ptr<PairSource>> sources;
    sources.push_back(std::make_unique<MemorySource>(2, 1000, inverted));
    BenchmarkRunner(config_, folder, listener, stop).run(sources);
    const std::vector<TruthCheck> checks = truthChecksTable().intactRows(
        readTextFile((fs::path(folder.path()) / truthChecksTable().file()).string()));
    ASSERT_EQ(checks.size(), 2U * 5);  // two pairs, five other readings of a homography
    for (const TruthCheck& check : checks) EXPECT_EQ(check.features, "orb+orb") << "the first ones";
    EXPECT_EQ(listener.texts.size(), inverted ? 1U : 0U);
    EXPECT_EQ(folder.doubtfulTruths().size(), listener.texts.size());
    if (!inverted) continue;
    EXPECT_EQ(folder.doubtfulTruths().front().text(), listener.texts.front());
    EXPECT_TRUE(contains(listener.texts.front(), "memory/scene: ")) << listener.texts.front();
  }
}

TEST_F(Runner, DoubtsAboutALongSequenceAreReportedBeforeItEnds) {
  struct Listener : RunObserver {
    void progress(const Progress& progress) override { done = progress.done; }
    void doubtful(const TruthWarning& warning) override { reported.emplace_back(done, warning.pairs); }
    std::size_t done = 0;
    std::vector<std::pair<std::size_t, std::size_t>> reported;  // pairs done, pairs counted
  } listener;
  config_.features = {"orb+orb"};
  config_.selectors = {"lpm"};
  config_.resolve();
  const std::atomic<bool> stop{false};
  RunFolder folder((root_ / "long").string(), config_, false);
  std::vector<std::unique_ptr<PairSource>> sources;
  sources.push_back(std::make_unique<MemorySource>(11, 1000, true));
  BenchmarkRunner(config_, folder, listener, stop).run(sources);
  EXPECT_EQ(listener.reported, (std::vector<std::pair<std::size_t, std::size_t>>{{8, 8}, {11, 11}}));
}

TEST_F(Runner, WhatTheInputLacksIsNoticedOncePerRun) {
  /// Images of 1 megapixel that were stretched, or matches without descriptor distances.
  class Source : public PairSource {
   public:
    std::size_t size() const override { return 6; }
    bool next(ImagePair& pair) override {
      pair = ImagePair();
      pair.id = {at_ < 3 ? "images" : "matches", "scene", std::to_string(at_)};
      pair.truth.kind = TruthKind::kHomography;
      if (at_ < 3) {
        pair.left = pair.right = cv::Mat(1000, 1000, CV_8U, cv::Scalar(40));
        pair.stretched = StretchedBits{12, 4000 + at_, "a.png"};
      } else {
        for (int k = 0; k < 20; ++k) {
          const cv::Point2f point(static_cast<float>(10 * k), static_cast<float>(k * k));
          if (k == 0) pair.given.emplace();
          pair.given->add(point, point);
        }
      }
      return at_++ < 6;
    }

   private:
    int at_ = 0;
  };
  struct Listener : RunObserver {
    void noticed(const Remark& remark) override { sentences.push_back(remark.sentence()); }
    std::vector<std::string> sentences;
  } listener;
  config_.selectors = {"nnsr", "gms"};
  config_.options = {{"orb", {{"max_megapixels", "0.25"}}}};
  config_.resolve();
  RunFolder folder((root_ / "run").string(), config_, false);
  std::vector<std::unique_ptr<PairSource>> list;
  list.push_back(std::make_unique<Source>());
  const std::atomic<bool> stop{false};
  BenchmarkRunner(config_, folder, listener, stop).run(list);
  EXPECT_EQ(
      listener.sentences,
      (std::vector<std::string>{
          "images: images of 16 bits that use 12 of them (values up to 4000 in a.png) are stretched",
          "large images are reduced before the features orb+orb are found in them: the left image of "
          "images/scene/0 (1000x1000 px) to a width of 500 px, by a factor of 2; the limit is the option "
          "orb.max_megapixels",
          "nnsr does not run on matches: nnsr needs the column distance",
          "gms does not run on matches: gms needs the size of the left image",
          "preselection by nnsr does not run on matches: nnsr needs the column distance"}));
  EXPECT_EQ(readRemarks(folder.path()).size(), 5U);
}

TEST_F(Runner, RepetitionsHaveTheirOwnSeedsAndMaxPairsCuts) {
  config_.repetitions = 2;
  config_.seed = 5;
  config_.max_pairs = 1;
  const Outcome outcome = run("repeated", 3);
  EXPECT_TRUE(outcome.state.complete());
  EXPECT_EQ(outcome.state.pairs_total, 1U);
  EXPECT_EQ(outcome.rows.size(), 1U + 2 * selections() * 2);
  std::set<std::string> seeds;
  double highest = 0;
  for (std::size_t i = 1; i < outcome.rows.size(); ++i) {
    const std::vector<std::string> fields = parseCsvLine(outcome.rows[i]);
    seeds.insert(fields[pairsTable(config_.tolerances).indexOf("seed")]);
    highest = std::max(
        highest, parseNumber(fields[pairsTable(config_.tolerances).indexOf("confidence")], "confidence"));
  }
  EXPECT_EQ(seeds, (std::set<std::string>{"5", "6"}));
  EXPECT_GT(highest, 50) << "the benchmark computes the confidence of every selection";
}

}  // namespace
}  // namespace corrsel::core
