#include <gtest/gtest.h>

#include <algorithm>
#include <map>
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
  ASSERT_EQ(names.size(), 13U);
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

TEST(Experiments, BudgetGivesEveryTimeLimitToSelectorsThatHaveOne) {
  EXPECT_EQ(
      experimentSelectors("budget", {"gms", "usac:h", "vfc[max_seconds=2]", "usac[threshold=3]"}, {}),
      (std::vector<std::string>{"gms", "usac:h[max_seconds=0.001]", "usac:h[max_seconds=0.003]",
                                "usac:h[max_seconds=0.01]", "usac:h[max_seconds=0.03]",
                                "usac:h[max_seconds=0.1]", "usac:h[max_seconds=0.3]", "vfc[max_seconds=2]",
                                "usac[max_seconds=0.001;threshold=3]", "usac[max_seconds=0.003;threshold=3]",
                                "usac[max_seconds=0.01;threshold=3]", "usac[max_seconds=0.03;threshold=3]",
                                "usac[max_seconds=0.1;threshold=3]", "usac[max_seconds=0.3;threshold=3]"}));
  BenchmarkConfig config = resolved("budget");
  EXPECT_EQ(cellsOf(config), std::set<std::string>{"sift+sift/none"});
  // Six of the paper's eight and auto have a limit; nnsr, gms, lpm and keep_all have none.
  EXPECT_EQ(config.selectors.size(), 6U * 6U + 4U);
  EXPECT_EQ(config.selectors.back(), "keep_all");
  const std::vector<std::string> once = config.selectors;
  config.resolve();
  EXPECT_EQ(config.selectors, once) << "variants have no variants";
}

TEST(Experiments, CurvesPutASelectorIntoTheRowOfItsVariants) {
  const auto curves = [](const std::vector<std::string>& selectors,
                         const std::map<std::string, OptionMap>& options = {}) {
    return experimentSelectors("curves", selectors, options);
  };
  EXPECT_EQ(curves({"lpm"}),
            (std::vector<std::string>{
                "lpm[lambda_first=0;lambda_second=0]", "lpm[lambda_first=2;lambda_second=2]",
                "lpm[lambda_first=4;lambda_second=4]", "lpm", "lpm[lambda_first=8;lambda_second=8]"}));
  const std::vector<std::string> gms = curves({"gms"});
  EXPECT_EQ(gms.size(), 9U);
  EXPECT_EQ(gms[4], "gms");
  EXPECT_EQ(gms[5], "gms[alpha=6]");
  // Where the options move the default, its old value is a variant.
  const std::vector<std::string> moved = curves({"gms"}, {{"gms", {{"alpha", "6"}}}});
  EXPECT_EQ(moved[4], "gms[alpha=4]");
  EXPECT_EQ(moved[5], "gms");
  // Otsu's threshold is none of the values.
  const std::vector<std::string> nnsr = curves({"nnsr"});
  EXPECT_EQ(nnsr.size(), 10U);
  EXPECT_EQ(nnsr[0], "nnsr");
  EXPECT_EQ(nnsr[1], "nnsr[max_threshold=0.4;min_threshold=0.4]");
  // What sets the parameter itself is one point, and what sets another option is not.
  const std::vector<std::string> single = {"lpm:v2", "nnsr:lowe", "gms[alpha=5]", "keep_all"};
  EXPECT_EQ(curves(single), single);
  EXPECT_EQ(curves({"gms:rotation[grid=10]"})[5], "gms:rotation[alpha=6;grid=10]");
  BenchmarkConfig config = resolved("curves");
  const std::vector<std::string> once = config.selectors;
  config.resolve();
  EXPECT_EQ(config.selectors, once) << "variants have no variants";
  EXPECT_TRUE(makesVariants("budget") && makesVariants("curves"));
  EXPECT_FALSE(makesVariants("paper") || makesVariants(""));
}

TEST(Experiments, MainParametersAreWithinTheirRanges) {
  for (const SelectorFactory& factory : builtInSelectors()) {
    SCOPED_TRACE(factory.name());
    const MainParameter& parameter = factory.mainParameter();
    EXPECT_EQ(parameter.empty(), factory.name() == "keep_all");
    for (const auto& [option, values] : parameter) {
      EXPECT_EQ(values.size(), parameter.front().second.size());
      EXPECT_GE(values.size(), 5U);
      EXPECT_TRUE(std::is_sorted(values.begin(), values.end()));
      EXPECT_EQ(std::set<double>(values.begin(), values.end()).size(), values.size());
    }
    const std::vector<std::string> variants = experimentSelectors("curves", {factory.name()}, {});
    for (const std::string& spec : variants) EXPECT_NO_THROW(createSelector(spec)) << spec;
    // The default is one of the values, unless it stands for a choice by the data or by the kind of model.
    const std::set<std::string> chosen_by_data = {"nnsr",   "auto",    "usac",   "acransac",
                                                  "mlesac", "multigs", "pnapsac"};
    const std::size_t own = chosen_by_data.count(factory.name());
    if (!parameter.empty()) {
      EXPECT_EQ(variants.size(), parameter.front().second.size() + own);
    }
  }
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
