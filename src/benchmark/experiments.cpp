#include "corrsel/benchmark/experiments.h"

#include <algorithm>
#include <cstdint>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::core {
namespace {

const std::vector<std::string> kPlanar = {"vgg", "symbench", "heinly"};
// The two reconstructed pairs are a dataset of their own: they never enter the means of the originals.
const std::vector<std::string> kAll = {"vgg", "symbench", "heinly", "adelaidermf",
                                       "adelaidermf_reconstructed"};

const std::vector<std::string> kVaried = {"vgg", "symbench", "adelaidermf"};

const Cell kDefault = {"hessian_affine+sift", "none"};
const Cell kPreselected = {"hessian_affine+sift", "nnsr"};
const std::vector<Cell> kCombinations = {
    {"sift+sift", "none"}, {"orb+orb", "none"}, {"asift+asift", "none"}, {"blob+freak", "none"}};

std::vector<Cell> allCells() {
  std::vector<Cell> cells = {kDefault, kPreselected};
  cells.insert(cells.end(), kCombinations.begin(), kCombinations.end());
  return cells;
}

/// What the selectors of an experiment are run with, one after another.
enum class Variants : std::uint8_t { kNone, kTimeLimits, kMainParameter };

struct Experiment {
  std::string name;
  std::vector<std::string> datasets;
  std::vector<Cell> cells;
  Variants variants = Variants::kNone;
};

constexpr char kTimeLimit[] = "max_seconds";
const std::vector<double> kTimeLimits = {0.001, 0.003, 0.01, 0.03, 0.1, 0.3};  // s

/// The paper's sections "Performance on the different datasets" to "Summary and discussion", in its order,
/// all of them together, and further experiments.
const std::vector<Experiment>& experiments() {
  static const std::vector<Experiment> all = {
      {"overall", kAll, {kDefault}},
      {"per_pair", kAll, {kDefault}},
      {"preselected", kPlanar, {kDefault, kPreselected}},
      {"features", kPlanar, kCombinations},
      {"robustness", {"vgg"}, {kDefault}},
      {"efficiency", kAll, {kDefault}},
      {"visual", kAll, {kDefault}},
      {"guide", kAll, allCells()},
      {"paper", kAll, allCells()},
      {"unrelated",
       {"vgg", "symbench"},
       {{"sift+sift", "none"}, {"orb+orb", "none"}, {"hessian_affine+sift", "none"}}},
      {"pose", {"sample", "vgg", "symbench"}, {{"sift+sift", "none"}, {"orb+orb", "none"}}},
      {"budget", kVaried, {{"sift+sift", "none"}}, Variants::kTimeLimits},
      {"curves", kVaried, {{"sift+sift", "none"}}, Variants::kMainParameter},
  };
  return all;
}

const Experiment& find(const std::string& name) {
  for (const Experiment& experiment : experiments()) {
    if (experiment.name == name) return experiment;
  }
  throw std::invalid_argument("unknown experiment '" + name + "'" + validNames(name, experimentNames()));
}

Variants variantsOf(const std::string& experiment) {
  return experiment.empty() ? Variants::kNone : find(experiment).variants;
}

/// The values of a selector's options as text.
OptionMap valuesOf(const Selector& selector) {
  OptionMap values;
  for (const OptionText& option : listOptions(selector.options())) values[option.name] = option.value;
  return values;
}

std::vector<std::string> withTimeLimits(const SelectorSpec& spec, const OptionMap& values) {
  if (values.count(kTimeLimit) == 0 || spec.options.count(kTimeLimit) > 0) return {spec.text()};
  std::vector<std::string> variants;
  for (const double seconds : kTimeLimits) {
    SelectorSpec variant = spec;
    variant.options[kTimeLimit] = formatNumber(seconds);
    variants.push_back(variant.text());
  }
  return variants;
}

/// Whether the preset or the brackets of the selector set one of the options.
bool sets(const SelectorSpec& spec, const SelectorFactory& factory, const MainParameter& options) {
  OptionMap set = spec.options;
  for (const auto& [preset, values] : factory.presets()) {
    if (spec.preset == preset) set.insert(values.begin(), values.end());
  }
  return std::any_of(options.begin(), options.end(),
                     [&set](const auto& option) { return set.count(option.first) > 0; });
}

std::vector<std::string> withMainParameter(const SelectorSpec& spec, const OptionMap& values) {
  const SelectorFactory factory = findSelector(spec.name);
  const MainParameter& parameter = factory.mainParameter();
  if (parameter.empty() || sets(spec, factory, parameter)) return {spec.text()};
  std::vector<std::string> variants;
  bool placed = false;
  for (std::size_t i = 0; i < parameter.front().second.size(); ++i) {
    SelectorSpec variant = spec;
    bool same = true;
    for (const auto& [option, swept] : parameter) {
      variant.options[option] = formatNumber(swept[i]);
      same = same && parseNumber(values.at(option), option) == swept[i];
    }
    variants.push_back(same ? spec.text() : variant.text());
    placed = placed || same;
  }
  if (!placed) variants.insert(variants.begin(), spec.text());
  return variants;
}

}  // namespace

std::vector<std::string> experimentNames() {
  std::vector<std::string> names;
  for (const Experiment& experiment : experiments()) names.push_back(experiment.name);
  return names;
}

std::vector<std::string> experimentDatasets(const std::string& name) { return find(name).datasets; }

std::vector<std::string> completeDatasets(const std::string& name, std::vector<std::string> datasets) {
  if (name != "unrelated") return datasets;
  const std::vector<std::string> given = datasets;
  for (const std::string& dataset : given) {
    const std::string unrelated = kUnrelatedPrefix + dataset;
    const bool there = std::find(datasets.begin(), datasets.end(), unrelated) != datasets.end();
    if (!isUnrelated(dataset) && !there) datasets.push_back(unrelated);
  }
  return datasets;
}

bool makesVariants(const std::string& name) { return variantsOf(name) != Variants::kNone; }

std::vector<std::string> experimentSelectors(const std::string& name,
                                             const std::vector<std::string>& selectors,
                                             const std::map<std::string, OptionMap>& options) {
  const Variants variants = variantsOf(name);
  if (variants == Variants::kNone) return selectors;
  std::vector<std::string> all;
  for (const std::string& text : selectors) {
    const SelectorSpec spec = SelectorSpec::fromText(text);
    const auto given = options.find(spec.name);
    const OptionMap values =
        valuesOf(*createSelector(text, given == options.end() ? OptionMap{} : given->second));
    const std::vector<std::string> own =
        variants == Variants::kTimeLimits ? withTimeLimits(spec, values) : withMainParameter(spec, values);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

void applyExperiment(const std::string& name, BenchmarkConfig& config) {
  config.experiment = name;
  if (config.selectors.empty()) config.selectors = {"all"};
  if (name.empty()) {
    if (config.features.empty()) config.features = {"sift+sift", "orb+orb"};
    if (config.preselection.empty()) config.preselection = {"none", "nnsr"};
    return;
  }
  const Experiment& experiment = find(name);
  config.sections = {name};
  if (name == "paper") {
    const std::vector<std::string> names = experimentNames();
    config.sections.assign(names.begin(), std::find(names.begin(), names.end(), name));
  }
  if (config.features.empty() && config.preselection.empty()) {
    config.cells = experiment.cells;
    return;
  }
  // The user's choice replaces that of the preset on one axis of the grid; the preset decides the other one.
  const bool features = config.features.empty(), preselection = config.preselection.empty();
  for (const Cell& cell : experiment.cells) {
    if (features) config.features.push_back(cell.features);
    if (preselection) config.preselection.push_back(cell.preselection);
  }
}

}  // namespace corrsel::core
