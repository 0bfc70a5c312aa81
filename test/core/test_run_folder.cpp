#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>

#include "benchmark/example_images.h"
#include "benchmark/tables.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/shard.h"
#include "result_rows.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;
using testing::posesOf;
using testing::rowsOf;

namespace fs = std::filesystem;

std::string readAll(const fs::path& file) {
  std::ifstream in(file);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

void writeAll(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

/// One extractor, two selections (gms, keep_all), two tolerances: four rows a pair.
BenchmarkConfig smallConfig() {
  BenchmarkConfig config;
  config.bags = {"a.bag"};
  config.features = {"orb+orb"};
  config.preselection = {"none"};
  config.selectors = {"gms"};
  config.tolerances = {5, 10};
  config.resolve();
  return config;
}

const std::vector<StageTime> kStages = {{"read", 0.5}, {"select", 0.25}};

/// A pair whose homography is inverted: 3 of 60 matches agree with it, 50 with the inverse.
std::vector<TruthCheck> checksOf(const std::string& pair) {
  TruthCheck check;
  check.id = {"set", "scene, \"one\"", pair};
  check.features = "orb+orb";
  check.kind = TruthKind::kHomography;
  check.reading = "inverse";
  check.n_putative = 60;
  check.n_truth = 3;
  check.n_reading = 50;
  return {check};
}

std::string warningsOf(const RunFolder& folder) {
  std::string text;
  for (const TruthWarning& warning : folder.doubtfulTruths()) text += warning.text() + "\n";
  return text;
}

class RunFolders : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("corrsel_results_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(RunFolders, FolderKeepsWhatWasAppendedAndResumes) {
  const BenchmarkConfig config = smallConfig();
  {
    RunFolder folder(folder_.string(), config, false);
    folder.appendPair(rowsOf("1-2"), 0, kStages);
    folder.appendPair(rowsOf("1-3"), 1, kStages);
    folder.appendFailure({{"set", "s", "1-9"}, "", "read", "a, b"});
  }
  const std::string complete = readAll(folder_ / "pairs.csv");
  // As if the process had been killed while writing the third pair.
  const std::string third = pairsTable(config.tolerances).line(rowsOf("1-4")[0]) +
                            pairsTable(config.tolerances).line(rowsOf("1-4")[1]).substr(0, 20);
  writeAll(folder_ / "pairs.csv", complete + third);
  RunFolder folder(folder_.string(), config, true);
  EXPECT_EQ(folder.doneCount(), 2U);
  EXPECT_TRUE(folder.isDone({"set", "scene, \"one\"", "1-3"}));
  EXPECT_FALSE(folder.isDone({"set", "scene, \"one\"", "1-4"}));
  EXPECT_EQ(readAll(folder_ / "pairs.csv"), complete);
  std::size_t count = 0;
  folder.forEachRow([&count](const ResultRow&) { ++count; });
  EXPECT_EQ(count, 4U);
}

TEST_F(RunFolders, RefusesOtherRuns) {
  BenchmarkConfig config = smallConfig();
  RunFolder(folder_.string(), config, false);
  std::string error = errorOf([&] { RunFolder(folder_.string(), config, false); });
  EXPECT_TRUE(contains(error, "resume the run")) << error;
  config.seed = 5;
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "another configuration") && contains(error, "seed: '0' -> '5'")) << error;
  config.seed = 0;
  writeAll(folder_ / "pairs.csv", "a,b,c\n");
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "no file of a benchmark run")) << error;
  writeAll(folder_ / "pairs.csv", "dataset,sequence,pair\n");
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "has format 1") && contains(error, "Run the benchmark again")) << error;
  fs::remove(folder_ / "config.yaml");
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "without its config.yaml")) << error;
}

TEST_F(RunFolders, RunThatWasKilledWhileItMadeTheFolderIsResumed) {
  RunFolder(folder_.string(), smallConfig(), false);
  fs::remove(folder_ / "config.yaml");
  EXPECT_EQ(RunFolder(folder_.string(), smallConfig(), true).doneCount(), 0U);
  EXPECT_TRUE(fs::exists(folder_ / "config.yaml"));
}

TEST_F(RunFolders, FolderThatCannotBeMade) {
  writeAll(folder_, "a file is in the way");
  const std::string error = errorOf([&] { RunFolder((folder_ / "run").string(), smallConfig(), false); });
  EXPECT_TRUE(contains(error, (folder_ / "run").string()) && contains(error, "output folder")) << error;
}

TEST_F(RunFolders, ImagesStayInTheFolderWhateverTheNames) {
  RunFolder folder(folder_.string(), smallConfig(), false);
  ExampleImage image;
  image.id = {"../..", "a/b", "<x>"};
  image.features = "orb+orb";
  image.selector = "lpm:v2";
  appendExampleImage(folder.path(), image, cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(9)));
  std::size_t pictures = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "images"))
    pictures += entry.path().extension() == ".jpg";
  EXPECT_EQ(pictures, 1U);
  EXPECT_TRUE(contains(readAll(folder_ / "images" / "index.csv"), "a/b,<x>,orb+orb"));
}

TEST_F(RunFolders, PairWithoutStagesIsRunAgain) {
  {
    RunFolder folder(folder_.string(), smallConfig(), false);
    folder.appendStage({"bag", 3}, "set");
    folder.appendPair(rowsOf("1-2"), 0, kStages);
    folder.appendPair(rowsOf("1-3"), 1, kStages);
  }
  const std::string stages = readAll(folder_ / "stages.csv");
  EXPECT_EQ(stages,
            "number,dataset,sequence,pair,stage,seconds\n"
            ",set,,,bag,3\n"
            "0,set,\"scene, \"\"one\"\"\",1-2,read,0.5\n0,set,\"scene, \"\"one\"\"\",1-2,select,0.25\n"
            "1,set,\"scene, \"\"one\"\"\",1-3,read,0.5\n1,set,\"scene, \"\"one\"\"\",1-3,select,0.25\n");
  writeAll(folder_ / "stages.csv", stages.substr(0, stages.find("1,set")));
  const RunFolder folder(folder_.string(), smallConfig(), true);
  EXPECT_EQ(folder.doneCount(), 1U);
  EXPECT_FALSE(folder.isDone(rowsOf("1-3").front().id));
  EXPECT_TRUE(contains(readAll(folder_ / "stages.csv"), ",set,,,bag,3"));
}

/// The stages of a pair that has rows in poses.csv.
std::vector<StageTime> stagesWithPose() {
  std::vector<StageTime> stages = kStages;
  stages.push_back({kPoseStage, 0.125});
  return stages;
}

TEST_F(RunFolders, PairWithoutAllItsPosesIsRunAgain) {
  {
    RunFolder folder(folder_.string(), smallConfig(), false);
    folder.appendPair(rowsOf("1-2"), 0, stagesWithPose(), {}, posesOf("1-2"));
    folder.appendPair(rowsOf("1-3"), 1, stagesWithPose(), {}, posesOf("1-3"));
    folder.appendPair(rowsOf("1-4"), 2, kStages);  // its pose is not known
  }
  EXPECT_EQ(RunFolder(folder_.string(), smallConfig(), true).doneCount(), 3U);
  const std::string poses = readAll(folder_ / "poses.csv");
  writeAll(folder_ / "poses.csv", poses.substr(0, poses.size() - 20));  // the last line is cut off
  {
    const RunFolder folder(folder_.string(), smallConfig(), true);
    EXPECT_EQ(folder.doneCount(), 2U);
    EXPECT_FALSE(folder.isDone(rowsOf("1-3").front().id));
    ASSERT_EQ(folder.readPoses().size(), 3U);
    EXPECT_EQ(folder.readPoses().back().id.pair, "1-2");
  }
  EXPECT_FALSE(contains(readAll(folder_ / "pairs.csv"), "1-3"));
  EXPECT_FALSE(contains(readAll(folder_ / "poses.csv"), "1-3"));
  std::string damaged = poses;
  damaged.replace(damaged.find("essential"), 9, "guesswork");
  writeAll(folder_ / "poses.csv", damaged);
  const std::string error = errorOf([&] { RunFolder(folder_.string(), smallConfig(), true); });
  EXPECT_TRUE(contains(error, "poses.csv, line 2: model: 'guesswork'")) << error;
}

TEST_F(RunFolders, RunOfAVersionWithoutPosesIsResumed) {
  { RunFolder(folder_.string(), smallConfig(), false).appendPair(rowsOf("1-2"), 0, kStages); }
  fs::remove(folder_ / "poses.csv");
  RunFolder folder(folder_.string(), smallConfig(), true);
  EXPECT_EQ(folder.doneCount(), 1U);
  folder.appendPair(rowsOf("1-3"), 1, stagesWithPose(), {}, posesOf("1-3"));
  EXPECT_EQ(folder.readPoses().size(), 3U);
}

TEST_F(RunFolders, PosesOfChangedLinesAreRefused) {
  RunFolder(folder_.string(), smallConfig(), false)
      .appendPair(rowsOf("1-2"), 0, stagesWithPose(), {}, posesOf("1-2"));
  EXPECT_EQ(readPoses(folder_.string()).size(), 3U);
  const std::string header = posesTable().header() + "\n";
  const struct {
    void (*change)(PoseRow& row);
    const char* text;
  } cases[] = {
      {[](PoseRow& row) { row.pose_error = 1; }, "pose_deg = 1 instead of 2"},
      {[](PoseRow& row) { row.rotation_error = 200; }, "rotation_deg = 200 is outside [0, 180]"},
      {[](PoseRow& row) { row.epipolar_precision = 1.5; }, "epipolar_precision = 1.5"},
      {[](PoseRow& row) { row.n_inliers = 41; }, "n_inliers = 41 exceeds n_selected = 40"},
      {[](PoseRow& row) { row.model = PoseModel::kNone; }, "rotation_deg = 2 with model none"},
      {[](PoseRow& row) { row.own.emplace().rotation_error = 1; }, "own_rotation_deg = 1 with motion none"},
      {[](PoseRow& row) { row.own.emplace().pose_error = 181; }, "own_pose_deg = 181 is outside [0, 180]"},
      {[](PoseRow& row) {
         row.own.emplace().normalized = {7, 4};
       },
       "nees = 7 with nees_degrees = 4"},
  };
  for (const auto& damaged : cases) {
    PoseRow row = posesOf("1-2")[0];
    damaged.change(row);
    writeAll(folder_ / "poses.csv", header + posesTable().line(row));
    const std::string error = errorOf([&] { readPoses(folder_.string()); });
    EXPECT_TRUE(contains(error, "poses.csv, line 2: ") && contains(error, damaged.text)) << error;
  }
  const std::string line = posesTable().line(posesOf("1-2")[0]);
  writeAll(folder_ / "poses.csv", header + line + line);
  EXPECT_TRUE(contains(errorOf([&] { readPoses(folder_.string()); }), "line 3: repeats the selection"));
  fs::remove(folder_ / "poses.csv");
  EXPECT_TRUE(readPoses(folder_.string()).empty());
}

TEST_F(RunFolders, SummaryPutsPairsIntoTheOrderOfTheUncutRun) {
  RunFolder folder(folder_.string(), smallConfig(), false);
  for (const auto& [pair, number] : {std::pair{"1-4", 7U}, std::pair{"1-2", 0U}, std::pair{"1-3", 3U}}) {
    TruthCheck check;
    check.id = rowsOf(pair).front().id;
    check.features = "orb+orb";
    check.kind = TruthKind::kHomography;
    check.reading = "inverse";
    folder.appendPair(rowsOf(pair), number, kStages, {check, check});
  }
  writeSummary(folder, {});
  std::vector<std::string> checked;
  for (const std::string& line : completeLines(readAll(folder_ / "truth_check.csv")))
    checked.push_back(parseCsvLine(line)[2]);
  EXPECT_EQ(checked, (std::vector<std::string>{"pair", "1-2", "1-2", "1-3", "1-3", "1-4", "1-4"}));
  std::vector<std::string> order;
  folder.forEachRow([&order](const ResultRow& row) { order.push_back(row.id.pair); });
  EXPECT_EQ(order, (std::vector<std::string>{"1-2", "1-2", "1-3", "1-3", "1-4", "1-4"}));
}

TEST_F(RunFolders, MergedPartsEqualTheWhole) {
  const BenchmarkConfig config = smallConfig();
  const fs::path whole = folder_ / "whole", merged = folder_ / "merged";
  const std::vector<std::string> pairs = {"1-2", "1-3", "1-4", "1-5", "1-6"};
  {
    RunFolder folder(whole.string(), config, false);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      folder.appendPair(rowsOf(pairs[k], 0.1 * k), k, stagesWithPose(), {}, posesOf(pairs[k], 0.5 * k));
    }
    writeSummary(folder, {});
  }
  std::size_t taken = 0;
  RunFolder folder(merged.string(), config, false);
  for (const char* part : {"3/3", "1/3", "2/3"}) {
    const Shard shard = Shard::fromText(part);
    const std::string path = (folder_ / ("part" + std::to_string(shard.index))).string();
    RunFolder of_part(path, config, false);
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (!shard.holds(k)) continue;
      of_part.appendPair(rowsOf(pairs[k], 0.1 * k), k, stagesWithPose(), {}, posesOf(pairs[k], 0.5 * k));
    }
    taken += mergeRun(folder, path, config);
    EXPECT_EQ(mergeRun(folder, path, config), 0U);
  }
  EXPECT_EQ(taken, pairs.size());
  writeSummary(folder, {});
  for (const char* file : {"pairs.csv", "poses.csv", "summary.csv", "pose_summary.csv", "config.yaml"}) {
    EXPECT_EQ(readAll(merged / file), readAll(whole / file)) << file;
  }
  EXPECT_TRUE(contains(readAll(merged / "environment.json"), "merged_from"));
  // What was merged stays known when the run is taken up again.
  RunFolder(merged.string(), config, true);
  EXPECT_TRUE(contains(readAll(merged / "environment.json"), "merged_from"));
}

TEST_F(RunFolders, DoubtfulTruthIsThatOfAllSessionsAndParts) {
  const BenchmarkConfig config = smallConfig();
  const fs::path first = folder_ / "first", second = folder_ / "second";
  RunFolder(first.string(), config, false).appendPair(rowsOf("1-2"), 0, kStages, checksOf("1-2"));
  {
    // As if the process had been killed after the checks of the next pair had been written.
    const RunFolder cut(first.string(), config, true);
    writeAll(first / "truth_check.csv",
             readAll(first / "truth_check.csv") + truthChecksTable().line(checksOf("1-3")[0]));
  }
  RunFolder folder(first.string(), config, true);
  EXPECT_TRUE(contains(warningsOf(folder), "3 of 60 putative matches agree")) << warningsOf(folder);
  folder.appendPair(rowsOf("1-3"), 1, kStages, checksOf("1-3"));
  EXPECT_TRUE(contains(warningsOf(folder), "6 of 120 putative matches agree")) << warningsOf(folder);

  RunFolder(second.string(), config, false).appendPair(rowsOf("1-4"), 2, kStages, checksOf("1-4"));
  mergeRun(folder, second.string(), config);
  const std::string whole = "9 of 180 putative matches agree with the homographies within 5 px, 150 with the";
  EXPECT_TRUE(contains(warningsOf(folder), whole)) << warningsOf(folder);
  writeSummary(folder, {});
  const std::string json = readAll(first / "summary.json");
  EXPECT_TRUE(contains(json, "\"n_truth\": 9") && contains(json, "\"n_reading\": 150")) << json;
  EXPECT_TRUE(contains(json, whole)) << json;
}

TEST_F(RunFolders, FolderOfAnOlderVersionHasNoChecks) {
  const BenchmarkConfig config = smallConfig();
  RunFolder(folder_.string(), config, false).appendPair(rowsOf("1-2"), 0, kStages);
  fs::remove(folder_ / "truth_check.csv");
  RunFolder folder(folder_.string(), config, true);
  EXPECT_EQ(folder.doneCount(), 1U);
  EXPECT_EQ(warningsOf(folder), "");
  folder.appendPair(rowsOf("1-3"), 1, kStages, checksOf("1-3"));
  EXPECT_TRUE(contains(warningsOf(folder), "3 of 60 putative matches agree")) << warningsOf(folder);
}

TEST_F(RunFolders, MergingWhatDoesNotBelongTogetherIsRefused) {
  BenchmarkConfig config = smallConfig();
  const std::string mine = (folder_ / "mine").string(), other = (folder_ / "other").string();
  RunFolder folder(mine, config, false);
  std::string error = errorOf([&] { mergeRun(folder, other, config); });
  EXPECT_TRUE(contains(error, other) && contains(error, "holds no run")) << error;
  BenchmarkConfig another = config;
  another.seed = 9;
  RunFolder(other, another, false).appendPair(rowsOf("1-2"), 0, kStages);
  error = errorOf([&] { mergeRun(folder, other, config); });
  EXPECT_TRUE(contains(error, "seed: '9' -> '0'") && contains(error, "same arguments")) << error;
  EXPECT_EQ(folder.doneCount(), 0U);
}

TEST_F(RunFolders, FolderEditedByHandNamesTheLine) {
  const BenchmarkConfig config = smallConfig();
  RunFolder(folder_.string(), config, false).appendPair(rowsOf("1-2"), 0, kStages);
  const std::string text = readAll(folder_ / "pairs.csv");
  std::string edited = text;
  edited.replace(edited.find(",60,") + 1, 2, "high");
  writeAll(folder_ / "pairs.csv", edited);
  std::string error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "pairs.csv, line 3") && contains(error, "'high'")) << error;
  writeAll(folder_ / "pairs.csv", text);
  writeAll(folder_ / "config.yaml", "datasets: [");
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "config.yaml is damaged")) << error;
}

TEST_F(RunFolders, RemarksAreKeptOnceAndMerged) {
  const Remark remark{"set", "", "gms", "needs, \"both\" sizes"}, other{"", "", "", "another one"};
  const std::string part = (folder_ / "part").string(), whole = (folder_ / "whole").string();
  for (const bool resume : {false, true}) {
    RunFolder folder(part, smallConfig(), resume);
    folder.appendRemark(remark);
    folder.appendRemark(remark);
    folder.appendRemark(other);
  }
  RunFolder merged(whole, smallConfig(), false);
  merged.appendRemark(other);
  mergeRun(merged, part, smallConfig());
  EXPECT_EQ(readAll(fs::path(part) / "remarks.csv"),
            remarksTable().header() + "\n" + remarksTable().line(remark) + remarksTable().line(other));
  EXPECT_EQ(readRemarks(whole).size(), 2U);
  EXPECT_EQ(remark.sentence(), "gms does not run on set: needs, \"both\" sizes");
  EXPECT_EQ((Remark{"set", "one", "", "is odd"}).sentence(), "set/one: is odd");
}

TEST_F(RunFolders, SummaryFilesTellTheState) {
  RunFolder folder(folder_.string(), smallConfig(), false);
  folder.appendPair(rowsOf("1-2"), 0, kStages);
  RunState state;
  state.pairs_done = 1;
  state.pairs_total = 2;
  EXPECT_FALSE(state.complete());
  state.left_out_datasets = {{"heinly", "not <there>"}};
  writeSummary(folder, state);
  const std::string json = readAll(folder_ / "summary.json");
  EXPECT_TRUE(contains(json, "\"dataset\": \"heinly\"") && contains(json, "not <there>")) << json;
  EXPECT_TRUE(contains(json, "\"complete\": false") && contains(json, "\"pairs_total\": 2")) << json;
  const std::string csv = readAll(folder_ / "summary.csv");
  EXPECT_TRUE(contains(csv, "set,orb+orb,none,gms,5,1,0.5,0.5,0.5,0.5,0.5,0.5,")) << csv;
  EXPECT_TRUE(fs::exists(folder_ / "environment.json") && fs::exists(folder_ / "failures.csv"));
  state.pairs_done = 2;
  EXPECT_TRUE(state.complete());
  state.pairs_failed = 1;
  EXPECT_FALSE(state.complete());
}

}  // namespace
}  // namespace corrsel::core
