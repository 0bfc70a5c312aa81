// The results on the sample set are those of test/regression/expected, and compare_runs notices where results
// are not. See README.md of that folder.

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <string>

#include "../ros/shell.h"
#include "benchmark/tables.h"
#include "datasets/sample.h"
#include "test_paths.h"

namespace corrsel {
namespace {

using testing::Output;
using testing::shell;

namespace fs = std::filesystem;

const fs::path kFolder = testing::sourceDir() + "/test/regression";
const fs::path kExpected = kFolder / "expected";

Output compare(const fs::path& before, const fs::path& after) {
  return shell((kFolder / "compare.sh").string() + " " + before.string() + " " + after.string());
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

class Regression : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::temp_directory_path() / ("corrsel_regression_" + std::to_string(getpid()));
    fs::remove_all(root_);
    fs::create_directories(root_);
  }
  void TearDown() override { fs::remove_all(root_); }

  /// A copy of the stored results with every row changed.
  fs::path changed(const std::function<void(core::ResultRow&)>& change) const {
    const fs::path copy = root_ / "changed";
    fs::copy(kExpected, copy);
    std::ifstream in(kExpected / "pairs.csv");
    std::ofstream out(copy / "pairs.csv");
    const core::CsvTable<core::ResultRow> table = core::pairsTableIn((kExpected / "pairs.csv").string());
    std::string line;
    for (std::size_t i = 0; i < table.headLines(); ++i) std::getline(in, line);
    out << table.head();
    while (std::getline(in, line)) {
      core::ResultRow row = table.parse(line);
      change(row);
      out << table.line(row);
    }
    return copy;
  }

  fs::path root_;
};

/// As if one in a hundred inliers of the mask had been exchanged for an outlier.
void worsen(core::ResultRow& row) {
  std::size_t& correct = row.metrics.front().n_correct;
  correct -= (correct + 99) / 100;
}

TEST_F(Regression, ResultsAreTheExpectedOnes) {
  const fs::path samples = core::sampleFolder();
  for (const std::string& image : core::SampleReader::imageNames()) {
    if (fs::exists(samples / image)) continue;
    GTEST_SKIP() << "skipped: the sample images are not here; run: rosrun corrsel fetch_samples.sh";
  }
  const Output run = shell("ROS_HOME=" + root_.string() + " " + (kFolder / "run.sh").string() + " " +
                           (root_ / "run").string());
  ASSERT_EQ(run.code, 0) << run.text;
  const Output comparison = compare(kExpected, root_ / "run");
  EXPECT_EQ(comparison.code, 0)
      << comparison.text
      << "\nif the change is meant: scripts/maintenance/update_regression.sh keeps the new results";
  std::cout << comparison.text;
}

TEST_F(Regression, WorseSelectionsAreNoticed) {
  for (const std::string selector : {"gms", "ransac"}) {
    fs::remove_all(root_ / "changed");
    const fs::path worse = changed([&selector](core::ResultRow& row) {
      if (row.selector == selector) worsen(row);
    });
    const Output output = compare(kExpected, worse);
    EXPECT_EQ(output.code, 1) << output.text;
    EXPECT_TRUE(contains(output.text, "sift+sift, none, " + selector)) << output.text;
    EXPECT_TRUE(contains(output.text, "1 worse")) << output.text;
    // Better results than the expected ones are a change too.
    EXPECT_EQ(compare(worse, kExpected).code, 1);
  }
}

TEST_F(Regression, MissingAndEditedRowsAreNoticed) {
  const fs::path copy = changed([](core::ResultRow& row) {
    if (row.selector == "lpm") row.selector = "lpm:v2";
  });
  const Output missing = compare(kExpected, copy);
  EXPECT_EQ(missing.code, 1) << missing.text;
  EXPECT_TRUE(contains(missing.text, "lpm: no rows of this group")) << missing.text;

  fs::remove_all(root_ / "changed");
  changed([](core::ResultRow& row) { row.metrics.front().n_correct = row.n_selected + 1; });
  const Output edited = compare(kExpected, copy);
  EXPECT_EQ(edited.code, 2) << edited.text;
  EXPECT_TRUE(contains(edited.text, "pairs.csv, line 3: n_correct_5px = ")) << edited.text;
}

TEST_F(Regression, ProgramSaysWhatItNeeds) {
  const std::string program = "rosrun corrsel compare_runs ", expected = kExpected.string();
  EXPECT_EQ(shell(program + "--help").code, 0);
  struct Case {
    std::string arguments, part;
  };
  for (const Case& c : {Case{"", "BEFORE, AFTER: 2 arguments"}, Case{expected, "1 given"},
                        Case{expected + " /does/not/exist", "/does/not/exist/config.yaml"},
                        Case{expected + " " + expected + " --metric f", "unknown metric 'f'"},
                        Case{expected + " " + expected + " --tau=3", "tau = 3 px"},
                        Case{expected + " " + expected + " --tolerance x", "'x' is not a number"},
                        Case{expected + " " + expected + " --nonsense", "'--nonsense'"},
                        Case{expected + " " + expected + " --tau", "--tau needs a value"}}) {
    const Output output = shell(program + c.arguments);
    EXPECT_EQ(output.code, 2) << c.arguments << "\n" << output.text;
    EXPECT_TRUE(contains(output.text, c.part)) << output.text;
  }
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
