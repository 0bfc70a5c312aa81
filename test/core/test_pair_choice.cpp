#include <gtest/gtest.h>

#include <string>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "dataset_folder.h"
#include "datasets/pair_choice.h"
#include "test_paths.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

using PairChoiceFile = DatasetFolder;

TEST_F(PairChoiceFile, IsOptional) {
  const PairChoice choice = readPairChoice(path());
  EXPECT_EQ(choice.step, 10);
  EXPECT_EQ(choice.max_pairs, 100);
}

TEST_F(PairChoiceFile, SetsOptions) {
  write("corrsel.yaml", "# ours\nstep: 30\npairs: stereo\nmin_baseline: 0.1\n");
  const PairChoice choice = readPairChoice(path());
  EXPECT_EQ(choice.step, 30);
  EXPECT_EQ(choice.pairs, FramePairs::kStereo);
  EXPECT_EQ(choice.min_baseline, 0.1);
  EXPECT_EQ(choice.max_pairs, 100);
  write("corrsel.yaml", "");
  EXPECT_EQ(readPairChoice(path()).step, 10);
}

TEST_F(PairChoiceFile, NamesOfEarlierVersionsAreRead) {
  write("corrsel.yaml", "most_pairs: 7\nleast_baseline: 0.2\nmost_gap: 0.5\nleast_points: 12\n");
  const PairChoice choice = readPairChoice(path());
  EXPECT_EQ(choice.max_pairs, 7);
  EXPECT_EQ(choice.min_baseline, 0.2);
  EXPECT_EQ(choice.max_gap, 0.5);
  EXPECT_EQ(choice.min_points, 12);
}

TEST_F(PairChoiceFile, FaultsNameFileOptionAndRemedy) {
  const auto errorFor = [&](const std::string& text) {
    write("corrsel.yaml", text);
    return errorOf<DatasetError>([&] { readPairChoice(path()); });
  };
  const std::string file = path("corrsel.yaml") + ": ";
  EXPECT_EQ(errorFor("step: 0\n"), file + "option step = 0 is outside [1, 100000]");
  EXPECT_EQ(errorFor("step: ten\n").find(file), 0u);
  EXPECT_TRUE(contains(errorFor("steps: 3\n"), "did you mean 'step'?")) << errorFor("steps: 3\n");
  EXPECT_TRUE(contains(errorFor("pairs: all\n"), "is not one of stereo, steps, both"));
  EXPECT_TRUE(contains(errorFor("step: [1\n"), "not readable as YAML"));
  for (const char* const text : {"- 3\n", "step 30\n"}) {
    EXPECT_EQ(errorFor(text), file + "has no lines 'option: value'; write one option a line, e.g. step: 30");
  }
}

TEST(PairChoiceOptions, AreThoseOfTheDocumentation) {
  const std::string docs = readTextFile(corrsel::testing::sourceDir() + "/docs/datasets.md");
  for (const OptionText& option : listOptions(PairChoice())) {
    const std::string unit = option.unit == "-" ? "" : " " + option.unit;
    EXPECT_TRUE(contains(docs, "| `" + option.name + "` | " + option.value + unit + " | "))
        << "| `" << option.name << "` | " << option.value << unit << " | " << option.description;
  }
}

}  // namespace
}  // namespace corrsel::core
