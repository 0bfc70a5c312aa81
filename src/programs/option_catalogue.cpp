// Prints the catalogue of all options as JSON: what options/catalogue.json holds. The configuration of the
// nodelets, config/live.yaml and the tables in docs/ are generated from it; see scripts/generate.py.

#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <string>

#include "base/ordered_json.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/guided.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/matching/sequence.h"
#include "corrsel/options.h"
#include "corrsel/reference/reference_selectors.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/tracking/flow_matcher.h"
#include "programs/degenerate_inputs.h"
#include "ros/live/nodelet_parameters.h"

namespace corrsel {
namespace {

using Json = core::OrderedJson;

Json toJson(const core::OptionValue& option) {
  return std::visit([](const auto& value) { return Json(value); }, option);
}

/// @param live  the options with the default values of live use, where these differ from the others
Json describe(const core::OptionSet& options, const core::OptionSet* live = nullptr) {
  Json list = Json::array();
  for (const core::OptionField& field : core::optionFields(options)) {
    Json entry;
    entry["name"] = field.name;
    entry["type"] = core::toString(field.type);
    entry["default"] = toJson(field.get(options));
    if (live != nullptr && field.get(*live) != field.get(options)) {
      entry["live_default"] = toJson(field.get(*live));
    }
    if (field.type == core::OptionType::kInteger) {
      entry["min"] = static_cast<int>(field.min);
      entry["max"] = static_cast<int>(field.max);
    } else if (field.type == core::OptionType::kNumber) {
      entry["min"] = field.min;
      entry["max"] = field.max;
    }
    if (field.unit != "-") entry["unit"] = field.unit;
    entry["description"] = field.description;
    for (const core::OptionField::Named& choice : field.choices) {
      entry["choices"].push_back({{"name", choice.name}, {"meaning", choice.meaning}});
    }
    list.push_back(entry);
  }
  return list;
}

Json mainParameter(const core::SelectorFactory& selector) {
  Json parameter = Json::object();
  for (const auto& [option, values] : selector.mainParameter()) parameter[option] = values;
  return parameter;
}

Json selectors() {
  Json list = Json::array();
  for (const core::SelectorFactory& selector : core::builtInSelectors()) {
    Json presets = Json::object(), needs_of_presets = Json::object();
    const std::vector<std::string> needs = core::neededInput(*selector.create());
    for (const auto& [name, values] : selector.presets()) {
      presets[name] = Json(values);
      const std::vector<std::string> own = core::neededInput(*selector.create(name));
      if (own != needs) needs_of_presets[name] = own;
    }
    list.push_back({{"name", selector.name()},
                    {"group", core::toString(selector.group())},
                    {"meaning", selector.meaning()},
                    {"cost", selector.cost()},
                    {"needs", needs},
                    {"needs_of_presets", needs_of_presets},
                    {"presets", presets},
                    {"main_parameter", mainParameter(selector)},
                    {"options", describe(selector.create()->options())}});
  }
  return list;
}

/// What a selector returns for degenerate input.
Json specialCases(const std::string& spec) {
  const std::unique_ptr<core::Selector> selector = core::createSelector(spec);
  Json results = {{"min_matches", minMatches(*selector)}};
  for (const DegenerateInput& input : degenerateInputs()) {
    results[input.name] = describeSelection(*selector, input.matches);
  }
  return results;
}

/// Those of every selector, and of the presets that return something else.
Json specialCases() {
  Json list = Json::object();
  for (const core::SelectorFactory& factory : core::builtInSelectors()) {
    const std::string& name = factory.name();
    list[name] = specialCases(name);
    for (const auto& preset : factory.presets()) {
      const std::string spec = name + ":" + preset.first;
      const Json results = specialCases(spec);
      if (results != list[name]) list[spec] = results;
    }
  }
  return list;
}

Json features() {
  Json combinations = Json::array(), algorithms = Json::array();
  for (const core::FeatureCombination& combination : core::featureCombinations()) {
    combinations.push_back({{"name", combination.name}, {"meaning", combination.meaning}});
  }
  const auto live = liveFeatureAlgorithms();
  for (const auto& [name, options] : core::featureAlgorithms()) {
    const auto found = std::find_if(live.begin(), live.end(),
                                    [&name = name](const auto& entry) { return entry.first == name; });
    algorithms.push_back({{"name", name}, {"options", describe(*options, found->second.get())}});
  }
  return {{"combinations", combinations},
          {"detectors", core::detectorNames()},
          {"descriptors", core::descriptorNames()},
          {"algorithms", algorithms}};
}

/// What the nodelets have beside the options of algorithms.
Json nodelets() {
  Json list = Json::object();
  for (const auto& [name, parameters] : nodeletParameters()) list[name]["start"] = describe(*parameters);
  list["FeatureMatcher"]["changeable"] = describe(FeatureChoice());
  list["FeatureMatcher"]["region"] = describe(RegionParameters());
  list["Matcher"]["changeable"] = describe(MatcherChoice());
  list["Selector"]["changeable"] = describe(SelectorChoice());
  list["Tracker"]["changeable"] = describe(TrackerChoice());
  return list;
}

bool isOption(const Json& value) { return value.is_object() && value.contains("type"); }

/// Prints every option and every plain value in one line, so that differences between versions are easy to
/// read.
void print(const Json& value, const std::string& indent) {
  const bool nested = !isOption(value) && std::any_of(value.begin(), value.end(), [](const Json& part) {
    return part.is_structured() && !part.empty();
  });
  if (!nested) {
    std::cout << value.dump();
    return;
  }
  std::string separator = value.is_object() ? "{\n" : "[\n";
  for (const auto& part : value.items()) {
    std::cout << separator << indent << " ";
    if (value.is_object()) std::cout << Json(part.key()).dump() << ": ";
    print(part.value(), indent + " ");
    separator = ",\n";
  }
  std::cout << "\n" << indent << (value.is_object() ? "}" : "]");
}

}  // namespace
}  // namespace corrsel

int main() {
  using namespace corrsel;
  core::addReferenceSelectors();
  const Json catalogue = {{"selectors", selectors()},
                          {"special_cases", specialCases()},
                          {"features", features()},
                          {"matching", describe(core::MatchOptions())},
                          {"guided", describe(core::GuidedOptions())},
                          {"sequence", describe(core::SequenceOptions())},
                          {"flow", describe(core::FlowOptions())},
                          {"nodelets", nodelets()}};
  print(catalogue, "");
  std::cout << "\n";
  return 0;
}
