#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <thread>

#include "arbitrary.h"
#include "base/text.h"
#include "corrsel/selectors/factory.h"
#include "kernels/kernels.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Mask = std::vector<std::uint8_t>;

std::string refusal(const std::string& spec, const OptionMap& options = {}, const OptionMap& common = {}) {
  return errorOf<std::invalid_argument>([&] { createSelector(spec, options, common); });
}

OptionMap optionsOf(const Selector& selector) {
  OptionMap values;
  for (const OptionText& option : listOptions(selector.options())) values[option.name] = option.value;
  return values;
}

TEST(SelectorFactory, KnowsPresets) {
  EXPECT_EQ(selectorPresets("gms"), (std::vector<std::string>{"rotation", "scale", "rotation_scale"}));
  EXPECT_EQ(selectorPresets("lpm"), (std::vector<std::string>{"paper", "v1", "v2", "guided"}));
  EXPECT_EQ(selectorPresets("ransac"),
            (std::vector<std::string>{"h", "f", "count", "msac", "lo", "prosac", "lo_prosac"}));
  EXPECT_EQ(selectorPresets("st"), (std::vector<std::string>{"leordeanu_hebert"}));
  EXPECT_EQ(selectorPresets("gtm"), (std::vector<std::string>{"paper", "equilibrium"}));
  EXPECT_EQ(selectorPresets("usac"), (std::vector<std::string>{"h", "f", "e", "uniform", "frames", "paper"}));
  EXPECT_EQ(selectorPresets("vfc"), (std::vector<std::string>{"sparse", "guided"}));
  EXPECT_EQ(selectorPresets("nnsr"), (std::vector<std::string>{"lowe"}));
  EXPECT_TRUE(selectorPresets("keep_all").empty());
  for (const std::string& name : selectorNames()) {
    EXPECT_EQ(createSelector(name)->name(), name);
    for (const std::string& preset : selectorPresets(name)) {
      EXPECT_EQ(createSelector(name + ":" + preset)->name(), name);
    }
  }
}

TEST(SelectorFactory, ListsWhatIsValid) {
  const std::string names = "; valid: " + joinList(selectorNames());
  EXPECT_EQ(refusal("ransack"), "unknown selector 'ransack'; did you mean 'ransac'?" + names.substr(1));
  EXPECT_EQ(refusal(""), "unknown selector ''" + names);
  EXPECT_EQ(refusal("GMS:scale"), "unknown selector 'GMS'; did you mean 'gms'?" + names.substr(1));
  EXPECT_EQ(errorOf<std::invalid_argument>([] { selectorPresets("gsm"); }),
            "unknown selector 'gsm'; did you mean 'gms'?" + names.substr(1));
  EXPECT_EQ(refusal("lpm:v3"), "unknown preset 'v3' of selector lpm; valid: paper, v1, v2, guided");
  EXPECT_EQ(refusal("lpm:guide"),
            "unknown preset 'guide' of selector lpm; did you mean 'guided'? valid: paper, v1, v2, guided");
  EXPECT_EQ(refusal("lpm:"), "unknown preset '' of selector lpm; valid: paper, v1, v2, guided");
  EXPECT_EQ(refusal("nnsr:h"), "unknown preset 'h' of selector nnsr; valid: lowe");
  EXPECT_EQ(refusal("keep_all:h"), "unknown preset 'h' of selector keep_all; valid: none");
  EXPECT_EQ(refusal("nnsr", {{"fallbac", "3"}}),
            "unknown option nnsr.fallbac; did you mean 'fallback'? valid: fallback, min_threshold, "
            "max_threshold, min_confidence");
  EXPECT_EQ(refusal("keep_all", {{"seed", "3"}}), "unknown option keep_all.seed; valid: none");
}

TEST(SelectorFactory, NamesValuesOutOfRange) {
  EXPECT_EQ(refusal("gms", {{"grid", "1"}}), "gms: option grid = 1 is outside [2, 100]");
  EXPECT_EQ(refusal("gms", {{"alpha", "-0.5"}}), "gms: option alpha = -0.5 is outside [0, 100]");
  EXPECT_EQ(refusal("ransac", {{"threshold", "0"}}), "ransac: option threshold = 0 is outside [0.01, 1000]");
  EXPECT_EQ(refusal("ransac", {{"model", "affine"}}),
            "option ransac.model: 'affine' is not one of homography, fundamental, essential");
  EXPECT_EQ(refusal("ransac", {}, {{"seed", "-1"}}), "ransac: option seed = -1 is outside [0, 2147483647]");
  EXPECT_EQ(refusal("lpm", {{"k", "33"}}), "lpm: option k = 33 is outside [1, 32]");
  EXPECT_EQ(refusal("st", {{"threshold", "1.5"}}), "st: option threshold = 1.5 is outside [-1, 1]");
  EXPECT_EQ(refusal("gtm", {{"steps", "0"}}), "gtm: option steps = 0 is outside [1, 100000]");
  EXPECT_EQ(refusal("lpm:v2", {{"k", "2"}}),
            "lpm: option k = 2 is too small for cost = multiscale: at least 3");
  EXPECT_EQ(refusal("gms", {{"grid", "many"}}), "option gms.grid: 'many' is not a number");
  EXPECT_EQ(refusal("gms", {}, {{"grid", "101"}}), "gms: option grid = 101 is outside [2, 100]");
}

TEST(SelectorFactory, PresetsSetTheirOptions) {
  EXPECT_EQ(optionsOf(*createSelector("lpm:paper")), optionsOf(*createSelector("lpm")));
  EXPECT_EQ(optionsOf(*createSelector("ransac:h")), optionsOf(*createSelector("ransac")));
  EXPECT_EQ(optionsOf(*createSelector("gtm:paper")), optionsOf(*createSelector("gtm")));
  const struct {
    const char* spec;
    const char* name;
    OptionMap different;
  } cases[] = {
      {"st:leordeanu_hebert",
       "st",
       {{"affinity", "difference"}, {"threshold", "-1"}, {"one_to_one", "true"}}},
      {"gtm:equilibrium", "gtm", {{"dynamics", "equilibrium"}, {"lambda", "2e-05"}}},
      {"lpm:v1", "lpm", {{"lambda_second", "4"}}},
      {"lpm:v2",
       "lpm",
       {{"cost", "multiscale"},
        {"k", "6"},
        {"lambda_first", "0.8"},
        {"lambda_second", "0.5"},
        {"tau", "0.2"}}},
      {"ransac:f", "ransac", {{"model", "fundamental"}}},
      {"lpm:guided", "lpm", {{"guided", "true"}, {"k", "6"}}},
      {"vfc:sparse", "vfc", {{"control_points", "16"}}},
      {"vfc:guided", "vfc", {{"guided", "true"}, {"lambda", "6"}}},
      {"gms:rotation", "gms", {{"rotation", "true"}}},
      {"gms:scale", "gms", {{"scale", "true"}}},
      {"gms:rotation_scale", "gms", {{"rotation", "true"}, {"scale", "true"}}},
  };
  for (const auto& c : cases) {
    OptionMap expected = optionsOf(*createSelector(c.name));
    for (const auto& [name, value] : c.different) expected[name] = value;
    EXPECT_EQ(optionsOf(*createSelector(c.spec)), expected) << c.spec;
  }
}

TEST(SelectorFactory, DefaultsAreThoseOfThePaper) {
  const OptionMap gms = optionsOf(*createSelector("gms")), lpm = optionsOf(*createSelector("lpm"));
  const OptionMap ransac = optionsOf(*createSelector("ransac")), nnsr = optionsOf(*createSelector("nnsr"));
  const OptionMap st = optionsOf(*createSelector("st")), gtm = optionsOf(*createSelector("gtm"));
  EXPECT_EQ(st.at("affinity") + st.at("threshold"), "ratio0.3");
  EXPECT_EQ(gtm.at("dynamics") + gtm.at("steps") + gtm.at("lambda"), "replicator1000.0001");
  EXPECT_EQ(gms.at("alpha"), "4");
  EXPECT_EQ(gms.at("grid"), "20");
  EXPECT_EQ(gms.at("rotation") + gms.at("scale"), "falsefalse");
  EXPECT_EQ(lpm.at("k"), "4");
  EXPECT_EQ(lpm.at("lambda_first") + lpm.at("lambda_second"), "66");
  EXPECT_EQ(ransac.at("threshold"), "10");
  EXPECT_EQ(ransac.at("max_iterations"), "2000");
  EXPECT_EQ(nnsr.at("fallback"), "0.8");
  const OptionMap vfc = optionsOf(*createSelector("vfc"));
  EXPECT_EQ(vfc.at("beta") + " " + vfc.at("lambda"), "0.1 3");
  EXPECT_EQ(vfc.at("threshold") + " " + vfc.at("inlier_ratio"), "0.75 0.9");
}

TEST(SelectorFactory, OptionsWinOverPresetAndPresetOverCommonValues) {
  const OptionMap common = {{"model", "homography"}, {"seed", "7"}, {"threshold", "2"}, {"nonsense", "x"}};
  OptionMap values = optionsOf(*createSelector("ransac:f", {}, common));
  EXPECT_EQ(values["model"], "fundamental");
  EXPECT_EQ(values["seed"], "7");
  EXPECT_EQ(values["threshold"], "2");
  values = optionsOf(*createSelector("ransac:f", {{"model", "homography"}, {"seed", "8"}}, common));
  EXPECT_EQ(values["model"], "homography");
  EXPECT_EQ(values["seed"], "8");
  EXPECT_EQ(values["threshold"], "2");
  EXPECT_EQ(optionsOf(*createSelector("gms", {}, common)), optionsOf(*createSelector("gms")));
}

struct StrangerOptions : OptionSet {
  double threshold = 1;
  int seed = 5;
  void visit(OptionVisitor& visitor) const override {
    visitor.number({"threshold", 0, 10, "px", "-"}, &StrangerOptions::threshold);
    visitor.integer({"seed", 0, 100, "-", "-"}, &StrangerOptions::seed);
  }
};

/// A selector of another package: selects the first match. "a/Throws..." throw, "a/Unchecked" forgets
/// check().
class Stranger : public Selector {
 public:
  explicit Stranger(std::string name) : name_(std::move(name)) {
    if (name_ == "a/ThrowsNumber") throw 7;
    if (name_ == "a/ThrowsError") throw std::runtime_error("no licence");
  }
  std::string name() const override { return name_; }
  const OptionSet& options() const override { return options_; }
  Presets presets() const override { return {{"loose", {{"threshold", "9"}}}, {"wrong", {{"size", "1"}}}}; }
  void configure(const OptionMap& values) override {
    ++configured;
    if (name_ == "a/ThrowsLater") throw std::domain_error("not today");
    setOptions(options_, values, name_);
    if (name_ != "a/Unchecked") options_.check();
  }
  int configured = 0;

 protected:
  void run(const Correspondences& matches, Workspace&, Selection& result) const override {
    if (!matches.empty()) result.mask[0] = 1;
  }

 private:
  std::string name_;
  StrangerOptions options_;
};

/// Knows Stranger as "a/...", for as long as it lives.
struct StrangersKnown {
  StrangersKnown() {
    setSelectorLoader([](const std::string& name) -> std::unique_ptr<Selector> {
      if (name == "a/Null") return nullptr;
      if (name.compare(0, 2, "a/") != 0) throw std::invalid_argument("unknown selector '" + name + "'");
      return std::make_unique<Stranger>(name);
    });
  }
  ~StrangersKnown() { setSelectorLoader({}); }
};

TEST(SelectorFactory, AsksTheLoaderForSelectorsOfOtherPackages) {
  EXPECT_EQ(
      refusal("a/B"),
      "selector 'a/B' belongs to another package, and this program cannot load selectors of other packages; "
      "valid: " +
          joinList(selectorNames()));
  EXPECT_TRUE(isPluginName("a/B") && isPluginName("a/B:c") && !isPluginName("gms:scale"));
  const StrangersKnown known;
  const std::unique_ptr<Selector> selector = createSelector("a/B");
  EXPECT_EQ(selector->name(), "a/B");
  EXPECT_EQ(dynamic_cast<Stranger&>(*selector).configured, 1);
  EXPECT_EQ(refusal("c/D"), "unknown selector 'c/D'");
  EXPECT_EQ(refusal("a/Null"), "selector 'a/Null' could not be made");
  EXPECT_EQ(refusal("B"), "unknown selector 'B'; valid: " + joinList(selectorNames()) +
                              ", package/Class of another package");
}

TEST(SelectorFactory, GivesOptionsToSelectorsOfOtherPackages) {
  const StrangersKnown known;
  const OptionMap common = {{"seed", "7"}, {"threads", "4"}, {"threshold", "2"}};
  EXPECT_EQ(optionsOf(*createSelector("a/B")), (OptionMap{{"threshold", "1"}, {"seed", "5"}}));
  EXPECT_EQ(optionsOf(*createSelector("a/B", {{"threshold", "3"}}, common)),
            (OptionMap{{"threshold", "3"}, {"seed", "7"}}));
  EXPECT_EQ(refusal("a/B", {{"treshold", "3"}}),
            "unknown option a/B.treshold; did you mean 'threshold'? valid: threshold, seed");
  EXPECT_EQ(refusal("a/B", {{"threshold", "x"}}), "option a/B.threshold: 'x' is not a number");
  EXPECT_EQ(refusal("a/B", {{"threshold", "11"}}), "a/B: option threshold = 11 is outside [0, 10]");
  EXPECT_EQ(refusal("a/Unchecked", {{"threshold", "11"}}),
            "a/Unchecked: option threshold = 11 is outside [0, 10]");
}

TEST(SelectorFactory, KnowsPresetsOfOtherPackages) {
  const StrangersKnown known;
  EXPECT_EQ(selectorPresets("a/B"), (std::vector<std::string>{"loose", "wrong"}));
  const OptionMap common = {{"seed", "7"}, {"threshold", "2"}};
  EXPECT_EQ(optionsOf(*createSelector("a/B:loose", {}, common)),
            (OptionMap{{"threshold", "9"}, {"seed", "7"}}));
  EXPECT_EQ(optionsOf(*createSelector("a/B:loose", {{"threshold", "3"}}, common)),
            (OptionMap{{"threshold", "3"}, {"seed", "7"}}));
  EXPECT_EQ(refusal("a/B:strict"), "unknown preset 'strict' of selector a/B; valid: loose, wrong");
  EXPECT_EQ(refusal("a/B:wrong"), "unknown option a/B.size; valid: threshold, seed");
  EXPECT_EQ(errorOf<std::invalid_argument>([] { selectorPresets("a/ThrowsError"); }),
            "a/ThrowsError: no licence");
}

TEST(SelectorFactory, BuiltInAndOtherSelectorsHaveOneInterface) {
  const StrangersKnown known;
  for (const std::string name : {"gms", "a/B"}) {
    const SelectorFactory factory = findSelector(name);
    EXPECT_EQ(factory.name(), name);
    EXPECT_EQ(factory.create()->name(), name);
    EXPECT_FALSE(factory.presets().empty());
    EXPECT_EQ(factory.group(), isPluginName(name) ? SelectorGroup::kOtherPackage : SelectorGroup::kPaper);
  }
  EXPECT_EQ(toString(findSelector("a/B").group()), "other packages");
}

TEST(SelectorFactory, ListsGroupByGroupThePaperFirstAndTheBaselineLast) {
  std::vector<std::string> paper;
  SelectorGroup before = SelectorGroup::kPaper;
  for (const SelectorFactory& selector : builtInSelectors()) {
    EXPECT_FALSE(selector.meaning().empty()) << selector.name();
    EXPECT_FALSE(selector.cost().empty()) << selector.name();
    EXPECT_LE(before, selector.group()) << selector.name();
    before = selector.group();
    if (selector.group() == SelectorGroup::kPaper) paper.push_back(selector.name());
  }
  EXPECT_EQ(paper, (std::vector<std::string>{"nnsr", "ransac", "st", "gtm", "usac", "vfc", "gms", "lpm"}));
  const std::vector<std::string> names = selectorNames();
  EXPECT_EQ(std::vector<std::string>(names.begin(), names.begin() + 8), paper);
  EXPECT_EQ(builtInSelectors().back().name(), "keep_all");
  paper.push_back("auto");
  paper.push_back("keep_all");
  EXPECT_EQ(usualSelectorNames(), paper);
  EXPECT_EQ(toString(builtInSelectors().back().group()), "baseline");
}

TEST(SelectorFactory, GroupsHaveDifferentNamesAndMeanings) {
  std::set<std::string> names, meanings;
  constexpr std::size_t kGroups = static_cast<std::size_t>(SelectorGroup::kOtherPackage) + 1;
  for (std::size_t i = 0; i < kGroups; ++i) {
    names.insert(toString(static_cast<SelectorGroup>(i)));
    meanings.insert(meaningOf(static_cast<SelectorGroup>(i)));
  }
  EXPECT_EQ(names.size(), kGroups);
  EXPECT_EQ(meanings.size(), kGroups);
  EXPECT_EQ(toString(SelectorGroup::kMultiStructure), "multi-structure");
}

TEST(SelectorFactory, NamesTheClassThatThrows) {
  const StrangersKnown known;
  EXPECT_EQ(refusal("a/ThrowsError"), "a/ThrowsError: no licence");
  EXPECT_EQ(refusal("a/ThrowsLater"), "a/ThrowsLater: not today");
  EXPECT_EQ(refusal("a/ThrowsNumber"),
            "a/ThrowsNumber: its class threw something that is not a std::exception");
}

TEST(SelectorFactory, LoaderMayChangeWhileSelectorsAreMade) {
  std::atomic<bool> stop{false};
  std::thread changing([&stop] {
    while (!stop) const StrangersKnown known;
  });
  int made = 0, refused = 0;
  for (int k = 0; k < 2000; ++k) {
    try {
      made += createSelector("a/B")->name() == "a/B";
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  stop = true;
  changing.join();
  EXPECT_EQ(made + refused, 2000);
}

TEST(SelectorFactory, CommonTimeLimitReplacesTheDefaultOnly) {
  const std::map<std::string, std::string> defaults = {
      {"ransac", "0"}, {"st", "30"}, {"gtm", "30"}, {"usac", "0"}, {"vfc", "0"}};
  const OptionMap common = {{"max_seconds", "0.25"}};
  for (const std::string& name : selectorNames()) {
    SCOPED_TRACE(name);
    const OptionMap before = optionsOf(*createSelector(name));
    if (before.count("max_seconds") == 0) {
      EXPECT_EQ(defaults.count(name), 0u);
      EXPECT_EQ(optionsOf(*createSelector(name, {}, common)), before);
      continue;
    }
    if (defaults.count(name) == 1) {
      EXPECT_EQ(before.at("max_seconds"), defaults.at(name));
    }
    OptionMap limited = before;
    limited["max_seconds"] = "0.25";
    EXPECT_EQ(optionsOf(*createSelector(name, {}, common)), limited);
    EXPECT_EQ(optionsOf(*createSelector(name, {{"max_seconds", "7"}}, common)).at("max_seconds"), "7");
    EXPECT_EQ(optionsOf(*createSelector(name, {{"max_seconds", "0"}}, common)).at("max_seconds"), "0");
    for (const std::string& preset : selectorPresets(name)) {
      OptionMap expected = optionsOf(*createSelector(name + ":" + preset));
      expected["max_seconds"] = "0.25";
      EXPECT_EQ(optionsOf(*createSelector(name + ":" + preset, {}, common)), expected) << preset;
    }
    EXPECT_EQ(refusal(name, {}, {{"max_seconds", "-1"}}),
              name + ": option max_seconds = -1 is outside [0, 1e+06]");
  }
}

/// Selectors, "name" or "name:preset", whose results on special input are stated in this file.
const std::vector<std::string> kSpecs = {"nnsr",
                                         "ransac:h",
                                         "ransac:f",
                                         "ransac:lo",
                                         "ransac:prosac",
                                         "usac:h",
                                         "usac:f",
                                         "st",
                                         "st:leordeanu_hebert",
                                         "gtm",
                                         "gtm:equilibrium",
                                         "vfc",
                                         "vfc:sparse",
                                         "vfc:guided",
                                         "gms",
                                         "gms:rotation_scale",
                                         "lpm",
                                         "lpm:v2",
                                         "lpm:guided",
                                         "auto",
                                         "auto:h",
                                         "keep_all"};

bool isListed(const std::string& name) {
  return std::any_of(kSpecs.begin(), kSpecs.end(),
                     [&name](const std::string& spec) { return spec.substr(0, spec.find(':')) == name; });
}

/// Those, and all other selectors of the factory.
std::vector<std::string> specsUnderTest() {
  std::vector<std::string> specs = kSpecs;
  for (const std::string& name : selectorNames()) {
    if (!isListed(name)) specs.push_back(name);
  }
  return specs;
}

/// What must hold for every selector, also for one that was added today.
class EverySelector : public ::testing::TestWithParam<std::string> {
 protected:
  std::string spec() const { return GetParam(); }
  std::string name() const { return spec().substr(0, spec().find(':')); }
  bool is(const std::string& prefix) const { return spec().rfind(prefix, 0) == 0; }
  bool fundamental() const { return is("ransac:f") || is("usac:f"); }
  /// Searches a model by random samples.
  bool samples() const { return name() == "ransac" || name() == "usac"; }
  bool calibrated() const { return needsCameras(*createSelector(spec())); }
  Selection select(const Correspondences& matches) const { return createSelector(spec())->select(matches); }

  /// A scene that the selector can solve.
  Scene scene(std::size_t n = 600, double inlier_ratio = 0.6, double noise = 0.5,
              std::uint64_t seed = 1) const {
    const SceneOptions options{n, inlier_ratio, noise, seed};
    Scene scene = fundamental() || calibrated() ? stereoScene(options) : homographyScene(options);
    if (calibrated()) addStereoCameras(scene);
    if (name() == "gtm" || !isListed(name())) addFrames(scene);
    return scene;
  }
};

/// What holds for the selectors of kSpecs. The tests of other selectors are in files of their own.
class ListedSelector : public EverySelector {};

void expectSame(const Selection& a, const Selection& b) {
  EXPECT_EQ(a.mask, b.mask);
  EXPECT_EQ(a.score, b.score);
  EXPECT_EQ(a.group, b.group);
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.message, b.message);
  EXPECT_EQ(a.model_kind, b.model_kind);
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.scene, b.scene);
  EXPECT_TRUE(a.confidence == b.confidence || (std::isnan(a.confidence) && std::isnan(b.confidence)))
      << a.confidence << ", " << b.confidence;
  EXPECT_TRUE(a.sigma == b.sigma || (std::isnan(a.sigma) && std::isnan(b.sigma)))
      << a.sigma << ", " << b.sigma;
  EXPECT_EQ(a.probability, b.probability);
}

TEST_P(ListedSelector, AnswersEveryNumberOfMatches) {
  const std::map<std::string, std::size_t> least = {{"vfc", 5},  {"vfc:sparse", 5}, {"vfc:guided", 5},
                                                    {"lpm", 6},  {"lpm:v2", 10},    {"lpm:guided", 8},
                                                    {"auto", 6}, {"auto:h", 6}};
  const std::size_t needed = least.count(spec()) ? least.at(spec()) : !samples() ? 0 : fundamental() ? 7 : 4;
  for (const std::size_t n : {0, 1, 2, 3, 4, 7, 8, 20}) {
    SCOPED_TRACE(n);
    const Selection s = select(scene(n, 1.0, 0.0, 3).matches);
    EXPECT_EQ(s.mask.size(), n);
    EXPECT_TRUE(s.score.empty() || s.score.size() == n);
    EXPECT_EQ(s.n_input, n);
    EXPECT_EQ(s.n_ignored, 0u);
    EXPECT_EQ(s.n_selected, selectedRows(s.mask).size());
    const bool unverified = samples() && n == needed;
    EXPECT_EQ(s.status, n < needed ? Status::kTooFew : unverified ? Status::kDegenerate : Status::kOk);
    if (n < needed || unverified || ((is("gms") || is("gtm") || is("st")) && n < 2)) {
      EXPECT_EQ(s.n_selected, 0u);
    }
    if (s.status != Status::kOk) {
      EXPECT_FALSE(s.message.empty());
    }
    if (name() == "keep_all" || (samples() && n > needed)) {
      EXPECT_EQ(s.n_selected, n);
    }
  }
}

TEST_P(EverySelector, KeepsATimeLimit) {
  // Few enough for selectors that refuse many matches.
  const OptionMap defaults = optionsOf(*createSelector(spec()));
  const auto most = defaults.find("max_matches");
  const Correspondences m =
      scene(most == defaults.end() ? 5000 : std::min(5000, std::stoi(most->second)), 0.02).matches;
  for (const double limit : {0.5, 5.5, 50.5}) {
    SCOPED_TRACE(limit);
    const auto selector = createSelector(spec(), {}, {{"max_seconds", formatNumber(limit)}});
    const bool limited = optionsOf(*selector).count("max_seconds") == 1;
    const TickingClock clock(1);
    const Selection s = selector->select(m);
    EXPECT_LE(clock.looks(), limited ? limit + 3 : 0) << "it continues after the end of its time";
    EXPECT_TRUE(s.status != Status::kOk || !limited || limit > 1);
    EXPECT_EQ(s.mask.size(), m.size());
    if (s.status != Status::kTooLarge && s.status != Status::kTimeLimit) continue;
    EXPECT_TRUE(limited) << toString(s.status) << ": " << s.message;
    EXPECT_EQ(s.status, s.iterations == 0 ? Status::kTooLarge : Status::kTimeLimit) << s.message;
    EXPECT_TRUE(contains(s.message, "stopped after " + std::to_string(s.iterations) + " ")) << s.message;
    EXPECT_TRUE(contains(s.message, ", max_seconds = " + formatNumber(limit))) << s.message;
    if (s.status == Status::kTooLarge) {
      EXPECT_EQ(s.mask, Mask(m.size(), 0));
      EXPECT_TRUE(s.score.empty());
    }
  }
}

TEST_P(EverySelector, HasLessConfidenceThanAskedForOnlyInTheStatus) {
  const Correspondences m = scene(2000).matches;
  Selection plain = select(m);
  ASSERT_EQ(plain.status, Status::kOk);
  const bool computes = optionsOf(*createSelector(spec())).count("min_confidence") == 1;
  EXPECT_EQ(computes, spec() != "keep_all");
  addConfidence(m, plain);
  EXPECT_GT(plain.confidence, spec() == "keep_all" ? -1 : 20);
  if (!computes) return;
  const Selection sure = createSelector(spec(), {{"min_confidence", "20"}})->select(m);
  expectSame(sure, plain);
  Selection unsure = createSelector(spec(), {{"min_confidence", "1000000"}})->select(m);
  EXPECT_EQ(unsure.status, Status::kUncertain);
  EXPECT_TRUE(contains(unsure.message, "below min_confidence = 1e+06")) << unsure.message;
  unsure.status = plain.status;
  unsure.message = plain.message;
  expectSame(unsure, plain);
}

TEST_P(EverySelector, HasLittleConfidenceInOutliers) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Correspondences m = scene(300, 0, 0.5, seed).matches;
    Selection s = createSelector(spec(), {}, {{"max_iterations", "2000"}})->select(m);
    addConfidence(m, s);
    EXPECT_LT(s.confidence, 3) << toString(s.status);
  }
}

TEST_P(ListedSelector, FindsTheRightMatches) {
  const std::map<std::string, std::pair<double, double>> floors = {{"nnsr", {99, 99}},
                                                                   {"ransac:h", {99, 99}},
                                                                   {"ransac:f", {90, 99}},
                                                                   {"ransac:lo", {99, 99}},
                                                                   {"ransac:prosac", {99, 99}},
                                                                   {"usac:h", {99, 99}},
                                                                   {"usac:f", {97, 98}},
                                                                   {"st", {97, 85}},
                                                                   {"st:leordeanu_hebert", {59, 99}},
                                                                   {"gtm", {98, 97}},
                                                                   {"gtm:equilibrium", {98, 97}},
                                                                   {"vfc", {97, 97}},
                                                                   {"vfc:sparse", {97, 97}},
                                                                   {"vfc:guided", {97, 97}},
                                                                   {"gms", {97, 85}},
                                                                   {"gms:rotation_scale", {97, 85}},
                                                                   {"lpm", {85, 99}},
                                                                   {"lpm:v2", {97, 97}},
                                                                   {"lpm:guided", {97, 97}},
                                                                   {"auto", {99, 99}},
                                                                   {"auto:h", {99, 99}},
                                                                   {"keep_all", {59, 100}}};
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Scene s = scene(2000, 0.6, 0.5, seed);
    const Quality q = quality(select(s.matches).mask, s.inlier);
    EXPECT_GE(q.precision, floors.at(spec()).first);
    EXPECT_GE(q.recall, floors.at(spec()).second);
  }
}

TEST_P(EverySelector, DoesNotDependOnTheOrder) {
  Correspondences m = scene().matches;
  // Ties: many-to-one matches, duplicates and positions on a lattice.
  for (std::size_t i = 0; i < 200; ++i) {
    m.left_x[i] = std::round(m.left_x[i] / 40) * 40;
    m.left_y[i] = std::round(m.left_y[i] / 40) * 40;
    if (i % 4 == 0) {
      m.right_x[i] = m.right_x[i + 1];
      m.right_y[i] = m.right_y[i + 1];
    }
  }
  std::vector<std::uint32_t> rows(m.size() + 50);
  for (std::uint32_t i = 0; i < rows.size(); ++i) rows[i] = i % std::uint32_t(m.size());
  m = m.subset(rows);
  const Selection expected = select(m);
  for (const std::uint64_t seed : {1, 2}) {
    const std::vector<std::uint32_t> order = permutation(m.size(), seed);
    const Selection s = select(m.subset(order));
    EXPECT_EQ(s.mask, reordered(expected.mask, order));
    if (!expected.score.empty()) {
      EXPECT_EQ(s.score, reordered(expected.score, order));
    }
    EXPECT_EQ(s.message, expected.message);
  }
}

TEST_P(EverySelector, IsNotInfluencedByUnusableRows) {
  const Scene clean = scene();
  const Selection expected = select(clean.matches);
  const float bad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                       -std::numeric_limits<float>::infinity(), 1.1e6f, -3e38f};
  // Every fifth row is a copy of another with one coordinate spoilt.
  std::vector<std::uint32_t> rows;
  std::vector<bool> spoilt;
  for (std::uint32_t i = 0; i < clean.matches.size(); ++i) {
    if (i % 4 == 0) {
      rows.push_back(i);
      spoilt.push_back(true);
    }
    rows.push_back(i);
    spoilt.push_back(false);
  }
  Correspondences m = clean.matches.subset(rows);
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (!spoilt[i]) continue;
    std::vector<float>* const columns[] = {&m.left_x, &m.left_y, &m.right_x, &m.right_y};
    (*columns[count % 4])[i] = bad[count % 5];
    ++count;
  }
  const Selection s = select(m);
  EXPECT_EQ(s.n_ignored, count);
  EXPECT_EQ(s.n_selected, expected.n_selected);
  EXPECT_EQ(s.iterations, expected.iterations);
  EXPECT_EQ(s.model, expected.model);
  EXPECT_EQ(s.message, expected.message);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    ASSERT_EQ(s.mask[i], spoilt[i] ? 0 : expected.mask[rows[i]]) << i;
    if (s.score.empty()) continue;
    ASSERT_TRUE(spoilt[i] ? std::isnan(s.score[i]) : s.score[i] == expected.score[rows[i]]) << i;
  }

  m.left_x.assign(m.size(), bad[0]);
  const Selection none = select(m), empty = select(m.subset({}));
  EXPECT_EQ(none.mask, Mask(m.size(), 0));
  EXPECT_EQ(none.status, empty.status);
}

TEST_P(ListedSelector, AnswersDuplicatesAlike) {
  const Scene once = scene(300);
  const std::size_t n = once.matches.size();
  std::vector<std::uint32_t> rows(3 * n);
  for (std::uint32_t i = 0; i < rows.size(); ++i) rows[i] = i % std::uint32_t(n);
  const Selection s = select(once.matches.subset(rows));
  EXPECT_EQ(s.status, Status::kOk);
  for (std::size_t i = 0; i < n; ++i) {
    EXPECT_EQ(s.mask[i], s.mask[i + n]);
    EXPECT_EQ(s.mask[i], s.mask[i + 2 * n]);
  }
  EXPECT_GT(quality(s.mask, reordered(once.inlier, rows)).recall, 80);
}

/// Gives all matches frames with the same affine map; nothing where they have none.
void setFrames(Correspondences& m, const cv::Matx22f& map) {
  if (m.left_frame.empty()) return;
  m.left_frame.assign(m.size(), AffineFrame{5, 0, 0, 0, 5, 0});
  m.right_frame.assign(m.size(),
                       AffineFrame{5 * map(0, 0), 5 * map(0, 1), 0, 5 * map(1, 0), 5 * map(1, 1), 0});
}

TEST_P(ListedSelector, AllPointsEqual) {
  Correspondences m = scene(50).matches;
  const Mask by_ratio = createSelector("nnsr")->select(m).mask;
  m.left_x.assign(50, 310);
  m.left_y.assign(50, 210);
  m.right_x.assign(50, 415);
  m.right_y.assign(50, 130);
  setFrames(m, {1, 0, 0, 1});
  const Selection s = select(m);
  if (name() == "nnsr") {
    EXPECT_EQ(s.mask, by_ratio);
  } else if (is("gms") || name() == "keep_all") {
    EXPECT_EQ(s.mask, Mask(50, 1));
    EXPECT_EQ(s.status, Status::kOk);
  } else if (name() == "st") {
    EXPECT_EQ(s.mask, Mask(50, 1));
    EXPECT_EQ(s.status, Status::kDegenerate);
  } else {
    EXPECT_EQ(s.mask, Mask(50, 0));
    EXPECT_EQ(s.model_kind, ModelKind::kNone);
    // One distinct match is too few where duplicates are merged.
    EXPECT_EQ(s.status, name() == "lpm" ? Status::kTooFew : Status::kDegenerate);
    EXPECT_FALSE(s.message.empty());
  }
}

TEST_P(ListedSelector, AllPointsOnALine) {
  Correspondences m = scene(200).matches;
  const Mask by_ratio = createSelector("nnsr")->select(m).mask;
  for (std::size_t i = 0; i < 200; ++i) {
    const float t = m.left_x[i];
    m.left_y[i] = 100 + 0.37f * t;
    m.right_x[i] = 0.9f * t + 20;
    m.right_y[i] = 400 - 0.21f * t;
  }
  setFrames(m, {0.9f, 0, -0.58f, 1});
  const Selection s = select(m);
  if (name() == "nnsr") {
    EXPECT_EQ(s.mask, by_ratio);
  } else if (samples()) {
    EXPECT_EQ(s.status, Status::kDegenerate);
    EXPECT_EQ(s.mask, Mask(200, 0));
  } else {
    EXPECT_EQ(s.status, Status::kOk);
    EXPECT_GE(s.n_selected, 190u);
  }
}

TEST_P(ListedSelector, IdenticalImages) {
  Correspondences m = scene(2000).matches;
  const Mask by_ratio = createSelector("nnsr")->select(m).mask;
  m.right_x = m.left_x;
  m.right_y = m.left_y;
  setFrames(m, {1, 0, 0, 1});
  const Selection s = select(m);
  if (name() == "nnsr") {
    EXPECT_EQ(s.mask, by_ratio);
  } else {
    EXPECT_EQ(s.status, Status::kOk);
    EXPECT_EQ(s.mask, Mask(2000, 1));
  }
}

TEST_P(EverySelector, AnswersAlikeAgainAndOnManyThreads) {
  const auto selector = createSelector(spec());
  std::vector<Scene> scenes;
  std::vector<Selection> expected;
  // Of different sizes, so that memory kept between calls would show.
  for (const std::size_t n : {900, 40, 400, 1}) {
    scenes.push_back(scene(n, 0.6, 0.5, n));
    expected.push_back(createSelector(spec())->select(scenes.back().matches));
  }
  for (const std::size_t n_threads : {1, 2, 4}) {
    SCOPED_TRACE(n_threads);
    std::vector<std::vector<Selection>> answers(n_threads);
    std::vector<std::thread> threads;
    for (std::size_t t = 0; t < n_threads; ++t) {
      threads.emplace_back([&, t] {
        for (std::size_t k = 0; k < 12; ++k) {
          answers[t].push_back(selector->select(scenes[(k + t) % 4].matches));
        }
      });
    }
    for (std::thread& thread : threads) thread.join();
    for (std::size_t t = 0; t < n_threads; ++t) {
      for (std::size_t k = 0; k < 12; ++k) expectSame(answers[t][k], expected[(k + t) % 4]);
    }
  }
}

/// A column of x or y and a frame's entries: three for x and three for y.
void moveSide(std::vector<float>& x, std::vector<float>& y, std::vector<AffineFrame>& frames, cv::Size& size,
              float scale, const cv::Point2f& shift) {
  for (float& value : x) value = value * scale + shift.x;
  for (float& value : y) value = value * scale + shift.y;
  for (AffineFrame& frame : frames) {
    for (float& value : frame) value *= scale;
    frame[2] += shift.x;
    frame[5] += shift.y;
  }
  size = {cvRound(float(size.width) * scale), cvRound(float(size.height) * scale)};
}

/// The same matches in images of `scale` times the size, then shifted by whole pixels, left and right by
/// different ones. Exact for multiples of 1/64 px.
Correspondences moved(Correspondences m, float scale, const cv::Point2f& left, const cv::Point2f& right) {
  moveSide(m.left_x, m.left_y, m.left_frame, m.left_size, scale, left);
  moveSide(m.right_x, m.right_y, m.right_frame, m.right_size, scale, right);
  return m;
}

/// Coordinates rounded to multiples of 1/64 px, so that they can be moved without further rounding.
Correspondences rounded(Correspondences m) {
  for (std::vector<float>* column : {&m.left_x, &m.left_y, &m.right_x, &m.right_y}) {
    for (float& value : *column) value = std::round(value * 64) / 64;
  }
  for (std::vector<AffineFrame>* frames : {&m.left_frame, &m.right_frame}) {
    for (AffineFrame& frame : *frames) {
      for (float& value : frame) value = std::round(value * 64) / 64;
    }
  }
  return m;
}

std::vector<std::uint32_t> changedRows(const Mask& a, const Mask& b) {
  Mask changed;
  for (std::size_t i = 0; i < std::max(a.size(), b.size()); ++i) {
    changed.push_back(i >= a.size() || i >= b.size() || a[i] != b[i] ? 1 : 0);
  }
  return selectedRows(changed);
}

const std::vector<std::uint32_t> kNoRows;

TEST_P(ListedSelector, DoesNotDependOnTheOrigin) {
  if (is("gms")) return;                          // its cells are parts of the image
  const bool displacements = spec() == "lpm:v2";  // compares how far matches move: the same shift for both
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE(seed);
    const Correspondences m = rounded(scene(600, 0.6, 0.5, seed).matches);
    const Selection expected = select(m);
    ASSERT_EQ(expected.status, Status::kOk) << expected.message;
    for (const auto& [left, right] : {std::pair{cv::Point2f(13, -7), cv::Point2f(-301, 250)},
                                      std::pair{cv::Point2f(1000, 1000), cv::Point2f(0, -2000)}}) {
      const Selection s = select(moved(m, 1, left, displacements ? left : right));
      EXPECT_EQ(changedRows(s.mask, expected.mask), kNoRows) << left;
    }
  }
}

TEST_P(ListedSelector, DoesNotDependOnTheUnit) {
  for (const float scale : {2.0F, 0.5F}) {
    SCOPED_TRACE(scale);
    // Thresholds in pixels grow with the images.
    OptionMap options, unscaled;
    if (name() == "usac") unscaled["threshold"] = fundamental() ? "1.5" : "10";  // what 0 means
    for (const OptionText& option : listOptions(createSelector(spec(), unscaled)->options())) {
      const double power = option.unit == "px" ? 1 : option.unit == "1/px" ? -1 : 0;
      if (power != 0)
        options[option.name] = formatNumber(std::pow(double(scale), power) * std::stod(option.value));
    }
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
      SCOPED_TRACE(seed);
      const Correspondences m = rounded(scene(600, 0.6, 0.5, seed).matches);
      const Selection expected = select(m);
      ASSERT_EQ(expected.status, Status::kOk) << expected.message;
      const Selection s = createSelector(spec(), options)->select(moved(m, scale, {0, 0}, {0, 0}));
      EXPECT_EQ(changedRows(s.mask, expected.mask), kNoRows);
    }
  }
}

TEST_P(EverySelector, AnswersAlikeWithEveryKernelLevel) {
  std::vector<Correspondences> inputs = {scene(1003).matches, scene(47, 0.8).matches, scene(0).matches};
  // Ties: positions on a lattice, each of them several times.
  inputs.push_back(scene(500).matches);
  for (std::vector<float>* column : {&inputs.back().left_x, &inputs.back().left_y}) {
    for (float& value : *column) value = std::round(value / 50) * 50;
  }
  const KernelLevel usual = kernelLevel();
  std::vector<Selection> expected;
  for (const KernelLevel level : supportedKernelLevels()) {
    setKernelLevel(level);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
      const Selection s = select(inputs[i]);
      if (expected.size() == i) expected.push_back(s);
      EXPECT_EQ(difference(s, expected[i]), "") << toString(level) << ", input " << i;
    }
  }
  setKernelLevel(usual);
}

TEST_P(EverySelector, KeepsItsContractOnArbitraryInput) {
  constexpr int kInputs = 300;
  std::map<Status, int> seen;
  for (int seed = 0; seed < kInputs; ++seed) {
    const std::uint8_t bytes[] = {std::uint8_t(seed), std::uint8_t(seed >> 8)};
    ByteSource source(bytes, sizeof bytes);
    Scene given;
    given.matches = arbitraryMatches(source);
    if (calibrated() && seed % 2 == 0) addStereoCameras(given);
    if (calibrated() && seed % 2 == 1) addArbitraryCameras(source, given.matches);
    const Correspondences& m = given.matches;
    const OptionMap options = arbitraryOptions(source, *createSelector(spec()));
    // The preset's own options, then drawn ones, which may contradict each other.
    std::vector<std::unique_ptr<Selector>> selectors;
    selectors.push_back(createSelector(spec(), {}, {{"max_iterations", "2000"}}));  // usac would take all day
    try {
      selectors.push_back(createSelector(spec(), options));
    } catch (const std::invalid_argument&) {
    }
    for (const auto& selector : selectors) {
      Selection s;
      ASSERT_NO_THROW(s = selector->select(m)) << "seed " << seed;
      ASSERT_EQ(contractViolation(m, s), "") << "seed " << seed;
      ASSERT_NO_THROW(addConfidence(m, s)) << "seed " << seed;
      ASSERT_EQ(contractViolation(m, s), "") << "seed " << seed;
      ++seen[s.status];
    }
  }
  // Otherwise the inputs are none that a selector works on.
  EXPECT_GT(seen[Status::kOk], calibrated() ? 0 : kInputs / 10);
  EXPECT_GT(seen[Status::kUnsupportedInput], 0);
}

TEST_P(EverySelector, RefusesInconsistentColumns) {
  Correspondences m = scene(30).matches;
  m.right_y.pop_back();
  const Selection s = select(m);
  EXPECT_EQ(s.status, Status::kUnsupportedInput);
  EXPECT_EQ(s.mask, Mask(30, 0));
  EXPECT_TRUE(contains(s.message, "right_y")) << s.message;
}

std::string testName(const ::testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::replace(name.begin(), name.end(), ':', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(All, EverySelector, ::testing::ValuesIn(specsUnderTest()), testName);
INSTANTIATE_TEST_SUITE_P(All, ListedSelector, ::testing::ValuesIn(kSpecs), testName);

TEST(ContractViolation, IsNoticed) {
  Correspondences m;
  for (const float x : {1.F, 2.F, std::numeric_limits<float>::quiet_NaN()}) m.add({x, 1}, {x, 2});
  const Selection good = createSelector("keep_all")->select(m);
  ASSERT_EQ(contractViolation(m, good), "");
  const auto broken = [&](const auto& change) {
    Selection s = good;
    change(s);
    return contractViolation(m, s);
  };
  EXPECT_EQ(broken([](Selection& s) { s.mask.pop_back(); }), "the mask has 2 rows");
  EXPECT_EQ(broken([](Selection& s) { s.mask[0] = 2; }), "the mask holds 2");
  EXPECT_EQ(broken([](Selection& s) { s.mask[0] = 0; }), "n_selected is 2");
  EXPECT_EQ(broken([](Selection& s) { s.mask[2] = 1; }), "row 2 is selected and not usable");
  EXPECT_EQ(broken([](Selection& s) { s.score = {1, 1, 1}; }), "row 2 has a score");
  EXPECT_EQ(broken([](Selection& s) { s.score = {1}; }), "there are 1 scores");
  EXPECT_EQ(broken([](Selection& s) { s.n_ignored = 0; }), "n_ignored is 0");
  EXPECT_EQ(broken([](Selection& s) { s.n_input = 2; }), "n_input is 2");
  EXPECT_EQ(broken([](Selection& s) { s.confidence = -1; }), "the confidence is negative or infinite");
  EXPECT_EQ(broken([](Selection& s) { s.status = Status::kDegenerate; }),
            "no message with status degenerate");
  EXPECT_EQ(broken([](Selection& s) { s.model_kind = ModelKind::kHomography; }),
            "the model is zero or not finite");
  EXPECT_EQ(broken([](Selection& s) {
              s.status = Status::kTooFew;
              s.message = "one";
            }),
            "matches are selected with status too_few");
  EXPECT_EQ(broken([](Selection& s) {
              s.status = Status::kFailed;
              s.message = "no memory";
            }),
            "failed: no memory");
  m.right_y.pop_back();
  EXPECT_EQ(contractViolation(m, good), "columns of different length pass");
}

}  // namespace
}  // namespace corrsel::core
