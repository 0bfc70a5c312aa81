#include "corrsel/benchmark/experiments.h"

#include <algorithm>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"

namespace corrsel::core {
namespace {

const std::vector<std::string> kPlanar = {"vgg", "symbench", "heinly"};
// The two reconstructed pairs are a dataset of their own: they never enter the means of the originals.
const std::vector<std::string> kAll = {"vgg", "symbench", "heinly", "adelaidermf",
                                       "adelaidermf_reconstructed"};

const Cell kDefault = {"hessian_affine+sift", "none"};
const Cell kPreselected = {"hessian_affine+sift", "nnsr"};
const std::vector<Cell> kCombinations = {
    {"sift+sift", "none"}, {"orb+orb", "none"}, {"asift+asift", "none"}, {"blob+freak", "none"}};

std::vector<Cell> allCells() {
  std::vector<Cell> cells = {kDefault, kPreselected};
  cells.insert(cells.end(), kCombinations.begin(), kCombinations.end());
  return cells;
}

struct Experiment {
  std::string name;
  std::vector<std::string> datasets;
  std::vector<Cell> cells;
};

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
  };
  return all;
}

const Experiment& find(const std::string& name) {
  for (const Experiment& experiment : experiments()) {
    if (experiment.name == name) return experiment;
  }
  throw std::invalid_argument("unknown experiment '" + name + "'" + validNames(name, experimentNames()));
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
