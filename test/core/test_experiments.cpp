#include <gtest/gtest.h>

#include <set>

#include "corrsel/benchmark/experiments.h"
#include "corrsel/selectors/factory.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

BenchmarkConfig resolved(const std::string& experiment, const std::vector<std::string>& features = {},
                         const std::vector<std::string>& preselection = {}) {
  BenchmarkConfig config;
  config.datasets = {"sample"};
  config.features = features;
  config.preselection = preselection;
  config.selectors = {};
  applyExperiment(experiment, config);
  config.resolve();
  return config;
}

std::set<std::string> cellsOf(const BenchmarkConfig& config) {
  std::set<std::string> cells;
  for (const Cell& cell : config.grid()) cells.insert(cell.text());
  return cells;
}

TEST(Experiments, PaperIsTheUnionOfThoseBeforeIt) {
  std::set<std::string> cells, datasets;
  std::vector<std::string> names = experimentNames();
  ASSERT_EQ(names.size(), 10U);
  EXPECT_EQ(names[8], "paper");
  names.resize(8);
  for (const std::string& name : names) {
    const BenchmarkConfig config = resolved(name);
    EXPECT_EQ(config.sections, std::vector<std::string>{name});
    EXPECT_EQ(config.selectors.size(), usualSelectorNames().size()) << name;
    const std::set<std::string> own = cellsOf(config);
    cells.insert(own.begin(), own.end());
    for (const std::string& dataset : experimentDatasets(name)) datasets.insert(dataset);
  }
  const BenchmarkConfig paper = resolved("paper");
  EXPECT_EQ(cellsOf(paper), cells);
  EXPECT_EQ(paper.cells.size(), 6U);
  EXPECT_EQ(paper.sections, names);
  const std::vector<std::string> all = experimentDatasets("paper");
  EXPECT_EQ(datasets, std::set<std::string>(all.begin(), all.end()));
  EXPECT_TRUE(paper.measuresScaling());
  EXPECT_FALSE(resolved("overall").measuresScaling());
}

TEST(Experiments, WhatTheUserNamesReplacesThePresets) {
  EXPECT_EQ(cellsOf(resolved("preselected", {"orb+orb"})),
            (std::set<std::string>{"orb+orb/none", "orb+orb/nnsr"}));
  EXPECT_EQ(cellsOf(resolved("features", {}, {"nnsr"})),
            (std::set<std::string>{"sift+sift/nnsr", "orb+orb/nnsr", "asift+asift/nnsr", "blob+freak/nnsr"}));
}

TEST(Experiments, UnrelatedAddsThePairsOfDifferentScenes) {
  const BenchmarkConfig config = resolved("unrelated");
  EXPECT_EQ(config.sections, std::vector<std::string>{"unrelated"});
  EXPECT_EQ(cellsOf(config),
            (std::set<std::string>{"sift+sift/none", "orb+orb/none", "hessian_affine+sift/none"}));
  const std::vector<std::string> completed = {"vgg", "symbench", "unrelated_vgg", "unrelated_symbench"};
  EXPECT_EQ(completeDatasets("unrelated", experimentDatasets("unrelated")), completed);
  EXPECT_EQ(completeDatasets("unrelated", completed), completed);
  EXPECT_EQ(completeDatasets("unrelated", {"unrelated_mine"}), std::vector<std::string>{"unrelated_mine"});
  EXPECT_EQ(completeDatasets("overall", {"vgg"}), std::vector<std::string>{"vgg"});
  EXPECT_TRUE(completeDatasets("unrelated", {}).empty());
}

TEST(Experiments, WithoutPresetTheDefaultsOfARun) {
  const BenchmarkConfig config = resolved("");
  EXPECT_EQ(config.grid().size(), 4U);
  EXPECT_TRUE(config.sections.empty());
  EXPECT_FALSE(config.measuresScaling());
}

TEST(Experiments, UnknownNameListsTheValidOnes) {
  const std::string error = errorOf([] { resolved("papers"); });
  EXPECT_TRUE(contains(error, "'papers'") && contains(error, "robustness")) << error;
}

}  // namespace
}  // namespace corrsel::core
