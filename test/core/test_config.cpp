#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <thread>

#include "corrsel/benchmark/config.h"
#include "corrsel/selectors/factory.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;

BenchmarkConfig sampleConfig() {
  BenchmarkConfig config;
  config.datasets = {"sample"};
  return config;
}

TEST(Config, ResolveExpandsAllAndAddsTheBaselineOnce) {
  BenchmarkConfig config = sampleConfig();
  config.features = {"sift+orb", "all", "orb+orb"};
  config.selectors = {"lpm:v2", "all", "keep_all", "lpm:v2"};
  config.resolve();
  EXPECT_EQ(config.features,
            (std::vector<std::string>{"sift+orb", "hessian_affine+sift", "sift+sift", "orb+orb",
                                      "asift+asift", "blob+freak", "akaze+akaze", "brisk+brisk"}));
  std::vector<std::string> expected = usualSelectorNames();
  expected.insert(expected.begin(), "lpm:v2");
  EXPECT_EQ(config.selectors, expected);
  config.selectors = {"every"};
  config.resolve();
  EXPECT_EQ(config.selectors, selectorNames());
}

TEST(Config, ResolveNamesWhatIsWrongAndWhatIsValid) {
  const auto errorWith = [](auto&& change) {
    BenchmarkConfig config = sampleConfig();
    change(config);
    return errorOf([&config] { config.resolve(); });
  };
  std::string error = errorWith([](BenchmarkConfig& c) { c.selectors = {"magic"}; });
  EXPECT_TRUE(contains(error, "'magic'") && contains(error, "gms")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.features = {"surf+surf"}; });
  EXPECT_TRUE(contains(error, "surf+surf") && contains(error, "orb+orb")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.preselection = {"ratio"}; });
  EXPECT_TRUE(contains(error, "ratio") && contains(error, "nnsr")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.options["gms"]["alpha"] = "-1"; });
  EXPECT_TRUE(contains(error, "gms") && contains(error, "alpha = -1") && contains(error, "[0, 100]"))
      << error;
  error = errorWith([](BenchmarkConfig& c) { c.options["gms"]["beta"] = "1"; });
  EXPECT_TRUE(contains(error, "gms.beta") && contains(error, "alpha")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.options["vfx"]["beta"] = "1"; });
  EXPECT_TRUE(contains(error, "'vfx'")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.repetitions = 0; });
  EXPECT_TRUE(contains(error, "repetitions = 0") && contains(error, "[1, 1000]")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.tolerances = {}; });
  EXPECT_TRUE(contains(error, "tolerances")) << error;
  const std::pair<std::vector<double>, const char*> wrong_tolerances[] = {
      {{0}, "tolerances: 0 px is outside (0, 1000] px; each must be above 0"},
      {{0, 1}, "tolerances: 0 px is outside"},
      {{-1, 1}, "tolerances: -1 px is outside"},
      {{std::nan("")}, "is outside (0, 1000] px"},
      {{1, INFINITY}, "tolerances: inf px is outside"},
      {{1, 1001}, "tolerances: 1001 px is outside"},
      {{1, 2, 2}, "tolerances: 2 px is given twice; give it once"},
      {{1, 5, 3}, "tolerances: 3 px comes after 5 px; give them in ascending order"},
  };
  for (const auto& [tolerances, words] : wrong_tolerances) {
    error = errorWith([values = tolerances](BenchmarkConfig& c) { c.tolerances = values; });
    EXPECT_TRUE(contains(error, words)) << error;
  }
  for (const int threads : {-1, 1025}) {
    error = errorWith([threads](BenchmarkConfig& c) { c.threads = threads; });
    EXPECT_EQ(error, "threads = " + std::to_string(threads) + " is outside [0, 1024]");
  }
  error = errorWith([](BenchmarkConfig& c) { c.seed = -1; });
  EXPECT_TRUE(contains(error, "seed = -1 is outside [0, ")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.max_pairs = -1; });
  EXPECT_TRUE(contains(error, "max_pairs = -1 is outside [0, ")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.options["gmz"]["alpha"] = "1"; });
  EXPECT_TRUE(contains(error, "'gmz', which this run does not use; did you mean 'gms'? used: ")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.preselection = {"nsnr"}; });
  EXPECT_EQ(error, "unknown preselection 'nsnr'; did you mean 'nnsr'? valid: none, nnsr");
  error = errorWith([](BenchmarkConfig& c) { c.ground_truth_tolerance = 3; });
  EXPECT_TRUE(contains(error, "10 px") && contains(error, "ground_truth_tolerance = 3")) << error;
  error = errorWith([](BenchmarkConfig& c) { c.datasets = {}; });
  EXPECT_TRUE(contains(error, "dataset")) << error;
}

TEST(Config, NoThreadsMeansAllCores) {
  BenchmarkConfig config = sampleConfig();
  config.threads = 0;
  config.resolve();
  EXPECT_EQ(config.threads, static_cast<int>(std::thread::hardware_concurrency()));
}

TEST(Config, RepeatedDatasetsAndBagsAreTakenOnce) {
  BenchmarkConfig config = sampleConfig();
  config.datasets = {"vgg", "sample", "vgg"};
  config.bags = {"/a.bag", "/a.bag"};
  config.resolve();
  EXPECT_EQ(config.datasets, (std::vector<std::string>{"vgg", "sample"}));
  EXPECT_EQ(config.bags, std::vector<std::string>{"/a.bag"});
}

TEST(Config, TwoBagsOfOneNameAreRefused) {
  BenchmarkConfig config;
  config.bags = {"/monday/run.bag", "/tuesday/run.bag"};
  EXPECT_TRUE(contains(errorOf([&] { config.resolve(); }),
                       "the bags /monday/run.bag and /tuesday/run.bag are both called 'run'"));
}

TEST(Config, OptionsBelongToDetectorOrDescriptor) {
  BenchmarkConfig config = sampleConfig();
  config.features = {"sift+orb"};
  config.options["sift"]["contrast_threshold"] = "0.07";
  config.options["orb"]["patch_size"] = "25";
  config.resolve();
  EXPECT_TRUE(contains(config.toYaml(), "contrast_threshold: 0.07")) << config.toYaml();
  EXPECT_TRUE(contains(config.toYaml(), "patch_size: 25")) << config.toYaml();
  config.options["brisk"]["octaves"] = "2";
  EXPECT_TRUE(contains(errorOf([&] { config.resolve(); }), "'brisk', which this run does not use"));
  config.options.erase("brisk");
  config.options["orb"]["patch_size"] = "1";
  EXPECT_TRUE(contains(errorOf([&] { config.resolve(); }), "orb: option patch_size = 1 is outside [5, 127]"));
  config.options.erase("orb");
  config.features = {"orb+akaze"};
  EXPECT_TRUE(contains(errorOf([&] { config.resolve(); }), "cannot work"));
}

TEST(Config, ImagesHaveOptionsForAllFeatures) {
  BenchmarkConfig config = sampleConfig();
  config.features = {"sift+orb", "orb+orb"};
  config.resolve();
  EXPECT_FALSE(contains(config.toYaml(), "equalize")) << "comparable with runs of earlier versions";
  config.options["image"]["equalize"] = "clahe";
  config.resolve();
  EXPECT_TRUE(contains(config.toYaml(), "equalize: clahe")) << config.toYaml();
}

TEST(Config, MatchingHasOptions) {
  BenchmarkConfig config = sampleConfig();
  config.options["match"]["mutual"] = "true";
  config.resolve();
  EXPECT_TRUE(contains(config.toYaml(), "mutual: true")) << config.toYaml();
  config.options["match"]["second_distance_radius"] = "-1";
  EXPECT_TRUE(contains(errorOf([&] { config.resolve(); }),
                       "match: option second_distance_radius = -1 is outside [0, 1000]"));
}

TEST(Config, OnlySelectorsThatDoNotFindTheModelThemselvesAreToldWhichItIs) {
  BenchmarkConfig config;
  config.seed = 3;
  EXPECT_EQ(config.offeredTo("usac", true, 2), (OptionMap{{"seed", "5"}, {"model", "homography"}}));
  EXPECT_EQ(config.offeredTo("acransac", false, 0), (OptionMap{{"seed", "3"}, {"model", "fundamental"}}));
  EXPECT_EQ(config.offeredTo("auto", false, 0), (OptionMap{{"seed", "3"}}));
}

TEST(Config, SelectorsMayCarryOptions) {
  BenchmarkConfig config = sampleConfig();
  config.selectors = {"gms[alpha=6]", "gms", "gms:scale[alpha=7;grid=10]", "nnsr[fallback=0.7]"};
  config.options["gms"]["alpha"] = "5";
  config.resolve();
  EXPECT_EQ(config.selectors, (std::vector<std::string>{"gms[alpha=6]", "gms", "gms:scale[alpha=7;grid=10]",
                                                        "nnsr[fallback=0.7]", "keep_all"}));
  EXPECT_EQ(config.optionsOf("gms:scale[alpha=7;grid=10]"), (OptionMap{{"alpha", "5"}}));
  EXPECT_TRUE(isNnsr("nnsr[fallback=0.7]") && !isNnsr("gms[alpha=6]"));
  EXPECT_EQ(config.offeredTo("usac[threshold=3]", false, 0),
            (OptionMap{{"seed", "0"}, {"model", "fundamental"}}));
  const std::string yaml = config.toYaml();
  BenchmarkConfig other = config;
  other.selectors[0] = "gms[alpha=8]";
  const std::string differences = ::testing::PrintToString(yamlDifferences(yaml, other.toYaml()));
  EXPECT_TRUE(contains(differences, "selector_options.gms[alpha=8].alpha: (absent) -> '8'")) << differences;
  EXPECT_TRUE(contains(differences, "selector_options.gms[alpha=6].alpha: '6' -> (absent)")) << differences;
  config.selectors = {"gms[alpha=101]"};
  EXPECT_EQ(errorOf([&] { config.resolve(); }),
            "selector 'gms[alpha=101]': gms: option alpha = 101 is outside [0, 100]");
  config.selectors = {"gms[alpha=6,grid=3]"};
  EXPECT_TRUE(contains(errorOf([&] { config.resolve(); }), "contains a comma"));
}

TEST(Config, OptionAssignments) {
  std::map<std::string, OptionMap> options;
  parseOptionAssignments("gms.alpha=6, ransac.threshold=1.5,gms.grid=10", options);
  EXPECT_EQ(options["gms"], (OptionMap{{"alpha", "6"}, {"grid", "10"}}));
  EXPECT_EQ(options["ransac"], (OptionMap{{"threshold", "1.5"}}));
  EXPECT_EQ(errorOf([] {
              std::map<std::string, OptionMap> twice;
              parseOptionAssignments("lpm.k=4,gms.alpha=6,lpm.k=5", twice);
            }),
            "options: lpm.k is given twice, as '4' and as '5'; give it once");
  for (const char* wrong : {"gms", "gms.alpha", "gms=3", ".alpha=3", "gms.=3"}) {
    EXPECT_TRUE(contains(errorOf([&] { parseOptionAssignments(wrong, options); }), wrong)) << wrong;
  }
}

TEST(Config, YamlHoldsEveryOptionAndDifferencesNameTheKeys) {
  BenchmarkConfig config = sampleConfig();
  config.options["gms"]["alpha"] = "6";
  config.resolve();
  const std::string yaml = config.toYaml();
  EXPECT_TRUE(yamlDifferences(yaml, yaml).empty());
  EXPECT_TRUE(contains(yaml, "alpha: 6")) << yaml;
  EXPECT_TRUE(contains(yaml, "contrast_threshold: 0.04")) << yaml;
  config.options["gms"]["alpha"] = "4";
  config.seed = 3;
  const std::string differences = ::testing::PrintToString(yamlDifferences(yaml, config.toYaml()));
  EXPECT_TRUE(contains(differences, "selector_options.gms.alpha: '6' -> '4'")) << differences;
  EXPECT_TRUE(contains(differences, "seed: '0' -> '3'")) << differences;
  EXPECT_TRUE(contains(errorOf([] { yamlDifferences("a: [1", "a: 1"); }), "YAML"));
}

TEST(Config, WhetherMatchesAreSavedIsPartOfARun) {
  BenchmarkConfig config = sampleConfig();
  config.resolve();
  const std::string without = config.toYaml();
  EXPECT_FALSE(contains(without, "save_matches")) << "runs of earlier versions would differ";
  config.save_matches = true;
  const std::string difference = ::testing::PrintToString(yamlDifferences(without, config.toYaml()));
  EXPECT_TRUE(contains(difference, "save_matches: (absent) -> 'true'")) << difference;
}

TEST(Config, CellsAreTheProductUnlessGiven) {
  BenchmarkConfig config = sampleConfig();
  config.features = {"orb+orb", "sift+sift"};
  config.preselection = {"none", "nnsr"};
  config.resolve();
  ASSERT_EQ(config.grid().size(), 4U);
  EXPECT_EQ(config.grid()[1].text(), "orb+orb/nnsr");
  EXPECT_TRUE(
      contains(config.toYaml(), "cells: [orb+orb/none, orb+orb/nnsr, sift+sift/none, sift+sift/nnsr]"))
      << config.toYaml();
  EXPECT_EQ(config.preselectionsOf("given"), config.preselection);

  BenchmarkConfig listed = sampleConfig();
  listed.experiment = "paper";
  listed.features = {"akaze+akaze"};
  listed.cells = {{"orb+orb", "nnsr"}, {"sift+sift", "none"}, {"orb+orb", "none"}};
  listed.resolve();
  EXPECT_EQ(listed.features, (std::vector<std::string>{"orb+orb", "sift+sift"}));
  EXPECT_EQ(listed.preselectionsOf("orb+orb"), (std::vector<std::string>{"nnsr", "none"}));
  EXPECT_EQ(listed.preselectionsOf("sift+sift"), (std::vector<std::string>{"none"}));
  EXPECT_EQ(listed.preselectionsOf("given"), (std::vector<std::string>{"none"}));
}

TEST(Config, TableToleranceIsThePapersWhereItIsEvaluated) {
  BenchmarkConfig config;
  EXPECT_EQ(config.tableTolerance(), 5.0);
  config.tolerances = {1, 8, 3};
  EXPECT_EQ(config.tableTolerance(), 8.0);
}

}  // namespace
}  // namespace corrsel::core
