#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <set>

#include "corrsel/benchmark/runner.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/random.h"
#include "corrsel/text.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

// Every selector, and every one but nnsr after nnsr.
constexpr std::size_t kSelections = 9 + 8;

using testing::contains;

namespace fs = std::filesystem;

/// Pairs made in memory: seeded blobs seen through a known homography; the pair numbered `broken` cannot be
/// read.
class MemorySource : public PairSource {
 public:
  explicit MemorySource(std::size_t size, std::size_t broken = 1000) : size_(size), broken_(broken) {}
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
      const cv::Point centre(static_cast<int>(random.index(320)), static_cast<int>(random.index(240)));
      cv::circle(pair.left, centre, 2 + static_cast<int>(random.index(9)),
                 cv::Scalar(random.uniform(60, 255)), -1);
    }
    pair.truth.kind = TruthKind::kHomography;
    pair.truth.matrix = cv::Matx33d(0.95, 0.05, 6, -0.04, 0.97, 9, 1e-5, 0, 1);
    cv::warpPerspective(pair.left, pair.right, pair.truth.matrix, pair.left.size());
    return true;
  }

 private:
  std::size_t size_, broken_, at_ = 0;
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

  Outcome run(const std::string& name, std::size_t pairs, bool resume = false, std::size_t broken = 1000,
              std::size_t stop_after = 1000) {
    struct Stopper : RunObserver {
      void progress(const Progress& progress) override { stop = stop || progress.done >= limit; }
      std::atomic<bool> stop{false};
      std::size_t limit = 0;
    } observer;
    observer.limit = stop_after;
    RunFolder folder((root_ / name).string(), config_, resume);
    std::vector<std::unique_ptr<PairSource>> sources;
    sources.push_back(std::make_unique<MemorySource>(pairs, broken));
    Outcome outcome;
    outcome.state = BenchmarkRunner(config_, folder, observer, observer.stop).run(sources);
    std::ifstream in(root_ / name / "pairs.csv");
    for (std::string line; std::getline(in, line);) {
      std::vector<std::string> fields = parseCsvLine(line);
      fields.resize(20);
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
  // Per pair: 2 features x kSelections x 2 tolerances.
  EXPECT_EQ(outcome.rows.size(), 1U + 2 * 2 * kSelections * 2);
  const std::vector<SummaryRow> summary =
      RunFolder((root_ / "run").string(), config_, true).writeSummary(outcome.state);
  for (const SummaryRow& row : summary) {
    if (row.selector == "ransac" && row.features == "sift+sift" && row.tau == 5) {
      EXPECT_GT(row.f_paper, 0.8);
    }
    if (row.selector == "keep_all" && row.preselection == "none") {
      EXPECT_LT(row.precision, 0.95);
    }
  }
  std::size_t pictures = 0;
  for (const auto& entry : fs::directory_iterator(root_ / "run" / "images")) {
    pictures += entry.path().extension() == ".jpg";
  }
  EXPECT_EQ(pictures, 2U * 8);  // one per pair and selector, the baseline left out
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

TEST_F(Runner, RepetitionsHaveTheirOwnSeedsAndMaxPairsCuts) {
  config_.repetitions = 2;
  config_.seed = 5;
  config_.max_pairs = 1;
  const Outcome outcome = run("repeated", 3);
  EXPECT_TRUE(outcome.state.complete());
  EXPECT_EQ(outcome.state.pairs_total, 1U);
  EXPECT_EQ(outcome.rows.size(), 1U + 2 * kSelections * 2 * 2);
  std::set<std::string> seeds;
  for (std::size_t i = 1; i < outcome.rows.size(); ++i) seeds.insert(parseCsvLine(outcome.rows[i])[19]);
  EXPECT_EQ(seeds, (std::set<std::string>{"5", "6"}));
}

}  // namespace
}  // namespace corrsel::core
