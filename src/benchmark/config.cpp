#include "corrsel/benchmark/config.h"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <stdexcept>
#include <thread>

#include "base/text.h"
#include "corrsel/benchmark/experiments.h"
#include "corrsel/features/extractor.h"
#include "corrsel/image_pair.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::core {
namespace {

constexpr double kTableTolerance = 5.0;   // px, of the paper's tables
constexpr double kMaxTolerance = 1000.0;  // px
constexpr int kMaxThreads = 1024;

std::string algorithmOf(const std::string& spec) { return SelectorSpec::fromText(spec).name; }

void requireRange(const std::string& name, double value, double min, double max) {
  if (!(value >= min && value <= max)) {
    throw std::invalid_argument(name + " = " + formatNumber(value) + " is outside [" + formatNumber(min) +
                                ", " + formatNumber(max) + "]");
  }
}

void requireAscending(const std::vector<double>& tolerances) {
  if (tolerances.empty()) throw std::invalid_argument("tolerances is empty: name at least one, in px");
  for (std::size_t i = 0; i < tolerances.size(); ++i) {
    const std::string tau = "tolerances: " + formatNumber(tolerances[i]) + " px ";
    // Written so that NaN fails.
    if (!(tolerances[i] > 0 && tolerances[i] <= kMaxTolerance)) {
      throw std::invalid_argument(tau + "is outside (0, " + formatNumber(kMaxTolerance) +
                                  "] px; each must be above 0");
    }
    if (i == 0 || tolerances[i] > tolerances[i - 1]) continue;
    if (tolerances[i] == tolerances[i - 1]) throw std::invalid_argument(tau + "is given twice; give it once");
    throw std::invalid_argument(tau + "comes after " + formatNumber(tolerances[i - 1]) +
                                " px; give them in ascending order");
  }
}

void requireSome(const std::string& name, const std::vector<std::string>& values) {
  if (values.empty()) throw std::invalid_argument(name + " is empty: name at least one");
}

std::vector<std::string> withoutRepeats(const std::vector<std::string>& values) {
  std::vector<std::string> result;
  for (const std::string& value : values) {
    if (std::find(result.begin(), result.end(), value) == result.end()) result.push_back(value);
  }
  return result;
}

void requireDistinctNames(const std::vector<std::string>& bags) {
  std::map<std::string, std::string> bag_of;
  for (const std::string& bag : bags) {
    const std::string name = bagName(bag);
    const auto [other, is_new] = bag_of.emplace(name, bag);
    if (is_new) continue;
    throw std::invalid_argument("the bags " + other->second + " and " + bag + " are both called '" + name +
                                "', which names their pairs in the results; rename one of them");
  }
}

/// The values, with the word replaced by all names.
std::vector<std::string> withAll(const std::vector<std::string>& values, const std::string& word,
                                 const std::vector<std::string>& names) {
  std::vector<std::string> result;
  for (const std::string& value : values) {
    if (value == word) {
      result.insert(result.end(), names.begin(), names.end());
    } else {
      result.push_back(value);
    }
  }
  return result;
}

/// The options of the matcher, checked.
MatchOptions matchOptions(const std::map<std::string, OptionMap>& given) {
  MatchOptions options;
  const auto found = given.find("match");
  if (found != given.end()) setOptions(options, found->second, "match");
  try {
    options.check();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(std::string("match: ") + error.what());
  }
  return options;
}

void emitOptions(YAML::Emitter& out, const std::string& name, const OptionSet& options) {
  out << YAML::Key << name << YAML::Value << YAML::BeginMap;
  for (const OptionText& option : listOptions(options))
    out << YAML::Key << option.name << YAML::Value << option.value;
  out << YAML::EndMap;
}

void flatten(const YAML::Node& node, const std::string& prefix, std::map<std::string, std::string>& out) {
  if (node.IsMap()) {
    for (const auto& child : node) {
      flatten(child.second, prefix + (prefix.empty() ? "" : ".") + child.first.as<std::string>(), out);
    }
  } else if (node.IsSequence()) {
    std::vector<std::string> items;
    for (const auto& child : node) items.push_back(child.as<std::string>());
    out[prefix] = "[" + joinList(items) + "]";
  } else {
    out[prefix] = node.IsScalar() ? node.Scalar() : "";
  }
}

std::map<std::string, std::string> flattened(const std::string& yaml) {
  std::map<std::string, std::string> out;
  try {
    flatten(YAML::Load(yaml), "", out);
  } catch (const YAML::Exception& error) {
    throw std::invalid_argument(std::string("not readable as YAML: ") + error.what());
  }
  return out;
}

}  // namespace

std::string bagName(const std::string& path) { return std::filesystem::path(path).stem().string(); }

void BenchmarkConfig::resolve() {
  std::vector<std::string> expanded =
      withAll(withAll(selectors, "all", usualSelectorNames()), "every", selectorNames());
  expanded.erase(std::remove(expanded.begin(), expanded.end(), "keep_all"), expanded.end());
  expanded.push_back("keep_all");
  for (const std::string& spec : expanded) createSelector(spec, optionsOf(spec));
  selectors = withoutRepeats(experimentSelectors(experiment, expanded, options));
  if (!cells.empty()) {
    features.clear();
    preselection.clear();
    for (const Cell& cell : cells) {
      features.push_back(cell.features);
      preselection.push_back(cell.preselection);
    }
  }
  features = withoutRepeats(withAll(features, "all", extractorNames()));
  preselection = withoutRepeats(preselection);
  requireSome("features", features);
  requireSome("preselection", preselection);
  datasets = withoutRepeats(datasets);
  bags = withoutRepeats(bags);
  requireDistinctNames(bags);
  if (datasets.empty() && bags.empty()) throw std::invalid_argument("neither a dataset nor a bag is given");
  const std::vector<std::string> preselections = {"none", "nnsr"};
  for (const std::string& name : preselection) {
    if (std::find(preselections.begin(), preselections.end(), name) == preselections.end()) {
      throw std::invalid_argument("unknown preselection '" + name + "'" + validNames(name, preselections));
    }
  }
  requireAscending(tolerances);
  requireRange("ground_truth_tolerance", ground_truth_tolerance, 0, kMaxTolerance);
  const double largest = tolerances.back();
  if (largest > ground_truth_tolerance) {
    throw std::invalid_argument(
        "tolerances: " + formatNumber(largest) +
        " px is above ground_truth_tolerance = " + formatNumber(ground_truth_tolerance) +
        " px, so that recall could exceed 1; lower the one or raise the other");
  }
  requireRange("repetitions", repetitions, 1, 1000);
  requireRange("threads", threads, 0, kMaxThreads);
  if (threads == 0) {
    threads = std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, kMaxThreads);
  }
  requireRange("seed", seed, 0, 2147483647 - 1000);
  requireRange("max_pairs", max_pairs, 0, 2147483647);

  std::set<std::string> known = {"nnsr", "match", kImageOptions};
  matchOptions(options);
  for (const std::string& name : features) {
    createExtractor(name, options);
    for (const std::string& algorithm : algorithmsOf(name)) known.insert(algorithm);
  }
  for (const std::string& spec : selectors) known.insert(algorithmOf(spec));
  const std::vector<std::string> used(known.begin(), known.end());
  for (const auto& [algorithm, values] : options) {
    if (!values.empty() && known.count(algorithm) == 0) {
      throw std::invalid_argument("options are given for '" + algorithm + "', which this run does not use" +
                                  validNames(algorithm, used, "used"));
    }
  }
}

std::string BenchmarkConfig::toYaml() const {
  YAML::Emitter out;
  out << YAML::BeginMap;
  out << YAML::Key << "experiment" << YAML::Value << experiment;
  out << YAML::Key << "sections" << YAML::Value << YAML::Flow << sections;
  out << YAML::Key << "datasets" << YAML::Value << YAML::Flow << datasets;
  out << YAML::Key << "data_root" << YAML::Value << data_root;
  out << YAML::Key << "bags" << YAML::Value << YAML::Flow << bags;
  out << YAML::Key << "bag_topics" << YAML::Value << YAML::Flow << bag_topics;
  std::vector<std::string> cell_names;
  for (const Cell& cell : grid()) cell_names.push_back(cell.text());
  out << YAML::Key << "cells" << YAML::Value << YAML::Flow << cell_names;
  out << YAML::Key << "selectors" << YAML::Value << YAML::Flow << selectors;
  std::vector<std::string> taus;
  for (const double tau : tolerances) taus.push_back(formatNumber(tau));
  out << YAML::Key << "tolerances" << YAML::Value << YAML::Flow << taus;
  out << YAML::Key << "ground_truth_tolerance" << YAML::Value << formatNumber(ground_truth_tolerance);
  out << YAML::Key << "repetitions" << YAML::Value << repetitions;
  out << YAML::Key << "threads" << YAML::Value << threads;
  out << YAML::Key << "seed" << YAML::Value << seed;
  out << YAML::Key << "max_pairs" << YAML::Value << max_pairs;
  // Results do not depend on it, so a run without it stays comparable with those of earlier versions. Pairs
  // that were run without it have no matches, so a run cannot be resumed or merged with another value.
  if (save_matches) out << YAML::Key << "save_matches" << YAML::Value << save_matches;
  out << YAML::Key << "feature_options" << YAML::Value << YAML::BeginMap;
  for (const std::string& name : features) {
    out << YAML::Key << name << YAML::Value << YAML::BeginMap;
    const auto extractor = createExtractor(name, options);
    for (const auto& [algorithm, values] : extractor->options()) {
      // Without options of the images a run stays comparable with those of earlier versions.
      if (algorithm == kImageOptions && options.count(algorithm) == 0) continue;
      emitOptions(out, algorithm, *values);
    }
    out << YAML::EndMap;
  }
  emitOptions(out, "match", matchOptions(options));
  out << YAML::EndMap;
  out << YAML::Key << "selector_options" << YAML::Value << YAML::BeginMap;
  for (const std::string& spec : selectors) {
    emitOptions(out, spec,
                createSelector(spec, optionsOf(spec), {{"seed", std::to_string(seed)}})->options());
  }
  out << YAML::EndMap << YAML::EndMap;
  return std::string(out.c_str()) + "\n";
}

OptionMap BenchmarkConfig::optionsOf(const std::string& spec) const {
  const auto found = options.find(algorithmOf(spec));
  return found == options.end() ? OptionMap{} : found->second;
}

OptionMap BenchmarkConfig::offeredTo(const std::string& spec, bool homography, int repetition) const {
  OptionMap offered = {{"seed", std::to_string(seed + repetition)}};
  const std::unique_ptr<Selector> selector = createSelector(spec);
  for (const OptionField& field : optionFields(selector->options())) {
    if (field.name == "model" && field.text(selector->options()) != "auto")
      offered["model"] = homography ? "homography" : "fundamental";
  }
  return offered;
}

std::vector<Cell> BenchmarkConfig::grid() const {
  if (!cells.empty()) return cells;
  std::vector<Cell> product;
  for (const std::string& name : features) {
    for (const std::string& before : preselection) product.push_back({name, before});
  }
  return product;
}

double BenchmarkConfig::tableTolerance() const {
  return std::find(tolerances.begin(), tolerances.end(), kTableTolerance) != tolerances.end()
             ? kTableTolerance
             : *std::max_element(tolerances.begin(), tolerances.end());
}

std::vector<std::string> BenchmarkConfig::preselectionsOf(const std::string& features_name) const {
  if (features_name == kGivenFeatures)
    return experiment.empty() ? preselection : std::vector<std::string>{"none"};
  std::vector<std::string> names;
  for (const Cell& cell : grid()) {
    if (cell.features == features_name) names.push_back(cell.preselection);
  }
  return names;
}

bool BenchmarkConfig::measuresScaling() const {
  return std::any_of(sections.begin(), sections.end(), [](const std::string& section) {
    return section == "efficiency" || section == "guide";
  });
}

bool isNnsr(const std::string& spec) { return algorithmOf(spec) == "nnsr"; }

void parseOptionAssignments(const std::string& text, std::map<std::string, OptionMap>& options) {
  for (const std::string& piece : splitList(text)) {
    const std::size_t dot = piece.find('.'), equals = piece.find('=');
    if (dot == std::string::npos || equals == std::string::npos || dot == 0 || equals < dot + 2) {
      throw std::invalid_argument("options: '" + piece +
                                  "' does not read as algorithm.option=value, e.g. gms.alpha=6");
    }
    const std::string value = piece.substr(equals + 1);
    OptionMap& values = options[piece.substr(0, dot)];
    const auto [before, inserted] = values.emplace(piece.substr(dot + 1, equals - dot - 1), value);
    if (!inserted) {
      throw std::invalid_argument("options: " + piece.substr(0, equals) + " is given twice, as '" +
                                  before->second + "' and as '" + value + "'; give it once");
    }
  }
}

std::vector<std::string> yamlDifferences(const std::string& before, const std::string& now) {
  const std::map<std::string, std::string> a = flattened(before), b = flattened(now);
  std::set<std::string> keys;
  for (const auto& item : a) keys.insert(item.first);
  for (const auto& item : b) keys.insert(item.first);
  const auto show = [](const std::map<std::string, std::string>& map, const std::string& key) {
    const auto found = map.find(key);
    return found == map.end() ? std::string("(absent)") : "'" + found->second + "'";
  };
  std::vector<std::string> differences;
  for (const std::string& key : keys) {
    const std::string old_value = show(a, key), new_value = show(b, key);
    if (old_value != new_value) differences.push_back(key + ": " + old_value + " -> " + new_value);
  }
  return differences;
}

}  // namespace corrsel::core
