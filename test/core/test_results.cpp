#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>

#include "corrsel/benchmark/results.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

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

std::vector<ResultRow> rowsOf(const std::string& pair, double f = 0.5) {
  std::vector<ResultRow> rows;
  for (const char* selector : {"gms", "keep_all"}) {
    for (const double tau : {5.0, 10.0}) {
      ResultRow row;
      row.id = {"set", "scene, \"one\"", pair};
      row.features = "orb+orb";
      row.preselection = "none";
      row.selector = selector;
      row.n_putative = 100;
      row.n_ground_truth = 50;
      row.n_selected = 40;
      row.metrics = {tau, 30, 0.75, 0.6, 0.65, f, f / 3};
      row.select_seconds = 0.001;
      rows.push_back(row);
    }
  }
  return rows;
}

class Results : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("corrsel_results_" + std::to_string(::getpid()));
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(Results, RowsReadBackAsWritten) {
  ResultRow row = rowsOf("1-2", 1.0 / 3)[0];
  row.metrics.precision = kUndefined;
  row.metrics.tau = kUndefined;
  row.detect_seconds = 0.1 + 0.2;
  row.seed = 7;
  row.status = Status::kTooFew;
  const ResultRow back = ResultRow::fromCsv(row.toCsv());
  EXPECT_EQ(back.toCsv(), row.toCsv());
  EXPECT_EQ(back.id, row.id);
  EXPECT_TRUE(std::isnan(back.metrics.precision));
  EXPECT_TRUE(std::isnan(back.metrics.tau));
  EXPECT_EQ(back.metrics.f_paper, 1.0 / 3);
  EXPECT_EQ(back.detect_seconds, 0.1 + 0.2);
  EXPECT_EQ(back.status, Status::kTooFew);
  EXPECT_TRUE(contains(errorOf([] { ResultRow::fromCsv("a,b"); }), "2 columns"));
}

TEST_F(Results, UnsupportedRowsHaveNoNumbers) {
  ResultRow row = rowsOf("1-2")[0];
  row.status = Status::kUnsupportedInput;
  EXPECT_EQ(row.toCsv(),
            "set,\"scene, \"\"one\"\"\",1-2,orb+orb,none,gms,5,0,0,100,50,,,,,,,,unsupported_input,0,,,,");
}

TEST_F(Results, SummaryIsTheMeanOfPerPairValues) {
  std::vector<ResultRow> rows = rowsOf("1-2", 0.2), more = rowsOf("1-3", 0.8), none = rowsOf("1-4", 0.1);
  for (ResultRow& row : none) row.n_ground_truth = 0;
  std::vector<ResultRow> unsupported = rowsOf("1-5", 0.1);
  for (ResultRow& row : unsupported) row.status = Status::kUnsupportedInput;
  // A second repetition of the first pair counts within the pair, not as a pair.
  std::vector<ResultRow> again = rowsOf("1-2", 0.4);
  for (const auto* list : {&more, &none, &unsupported, &again})
    rows.insert(rows.end(), list->begin(), list->end());
  rows[0].metrics.precision = kUndefined;
  const std::vector<SummaryRow> summary = summarize(rows);
  ASSERT_EQ(summary.size(), 4U);
  EXPECT_EQ(summary[0].selector, "gms");
  EXPECT_EQ(summary[0].tau, 5.0);
  EXPECT_EQ(summary[0].pairs, 2U);
  EXPECT_NEAR(summary[0].f_paper, (0.3 + 0.8) / 2, 1e-12);
  EXPECT_NEAR(summary[0].precision, 0.75, 1e-12);
  EXPECT_LE(summary[0].f_low, summary[0].f_paper);
  EXPECT_GE(summary[0].f_high, summary[0].f_paper);
  EXPECT_NEAR(summary[0].select_median, 0.001, 1e-12);
}

TEST_F(Results, FolderKeepsWhatWasAppendedAndResumes) {
  const BenchmarkConfig config = smallConfig();
  {
    RunFolder folder(folder_.string(), config, false);
    folder.appendPair(rowsOf("1-2"));
    folder.appendPair(rowsOf("1-3"));
    folder.appendFailure({{"set", "s", "1-9"}, "", "read", "a, b"});
  }
  const std::string complete = readAll(folder_ / "pairs.csv");
  // As if the process had been killed while writing the third pair.
  const std::string third = rowsOf("1-4")[0].toCsv() + "\n" + rowsOf("1-4")[1].toCsv().substr(0, 20);
  writeAll(folder_ / "pairs.csv", complete + third);
  RunFolder folder(folder_.string(), config, true);
  EXPECT_EQ(folder.doneCount(), 2U);
  EXPECT_TRUE(folder.isDone({"set", "scene, \"one\"", "1-3"}));
  EXPECT_FALSE(folder.isDone({"set", "scene, \"one\"", "1-4"}));
  EXPECT_EQ(readAll(folder_ / "pairs.csv"), complete);
  EXPECT_EQ(folder.readRows().size(), 8U);
}

TEST_F(Results, RefusesOtherRuns) {
  BenchmarkConfig config = smallConfig();
  RunFolder(folder_.string(), config, false);
  std::string error = errorOf([&] { RunFolder(folder_.string(), config, false); });
  EXPECT_TRUE(contains(error, "resume:=true")) << error;
  config.seed = 5;
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "another configuration") && contains(error, "seed: '0' -> '5'")) << error;
  config.seed = 0;
  writeAll(folder_ / "pairs.csv", "a,b,c\n");
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "another header")) << error;
  fs::remove(folder_ / "config.yaml");
  error = errorOf([&] { RunFolder(folder_.string(), config, true); });
  EXPECT_TRUE(contains(error, "without its config.yaml")) << error;
}

TEST_F(Results, FolderThatCannotBeMade) {
  writeAll(folder_, "a file is in the way");
  const std::string error = errorOf([&] { RunFolder((folder_ / "run").string(), smallConfig(), false); });
  EXPECT_TRUE(contains(error, (folder_ / "run").string()) && contains(error, "output_dir")) << error;
}

TEST_F(Results, ImagesStayInTheFolderWhateverTheNames) {
  RunFolder folder(folder_.string(), smallConfig(), false);
  ExampleImage image;
  image.id = {"../..", "a/b", "<x>"};
  image.features = "orb+orb";
  image.selector = "lpm:v2";
  folder.appendImage(image, cv::Mat(4, 4, CV_8UC3, cv::Scalar::all(9)));
  std::size_t pictures = 0;
  for (const auto& entry : fs::directory_iterator(folder_ / "images"))
    pictures += entry.path().extension() == ".jpg";
  EXPECT_EQ(pictures, 1U);
  EXPECT_TRUE(contains(readAll(folder_ / "images" / "index.csv"), "a/b,<x>,orb+orb"));
}

TEST_F(Results, SummaryFilesTellTheState) {
  RunFolder folder(folder_.string(), smallConfig(), false);
  folder.appendPair(rowsOf("1-2"));
  RunState state;
  state.pairs_done = 1;
  state.pairs_total = 2;
  EXPECT_FALSE(state.complete());
  folder.writeSummary(state);
  const std::string json = readAll(folder_ / "summary.json");
  EXPECT_TRUE(contains(json, "\"complete\": false") && contains(json, "\"pairs_total\": 2")) << json;
  const std::string csv = readAll(folder_ / "summary.csv");
  EXPECT_TRUE(contains(csv, "set,orb+orb,none,gms,5,1,0.75,0.6,0.5,0.5,0.5,0.65,")) << csv;
  EXPECT_TRUE(fs::exists(folder_ / "environment.json") && fs::exists(folder_ / "failures.csv"));
  state.pairs_done = 2;
  EXPECT_TRUE(state.complete());
  state.pairs_failed = 1;
  EXPECT_FALSE(state.complete());
}

}  // namespace
}  // namespace corrsel::core
