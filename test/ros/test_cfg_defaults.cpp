#include <corrsel/FeatureMatcherConfig.h>
#include <corrsel/MatcherConfig.h>
#include <corrsel/SelectorConfig.h>
#include <corrsel/TrackerConfig.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "base/text.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/guided.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/matching/sequence.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/tracking/flow_matcher.h"
#include "ros/live/live_tracker.h"
#include "ros/live/message_matcher.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"

namespace corrsel {
namespace {

/// A reconfigure parameter, its numbers as text.
struct Parameter {
  std::string type, standard, min, max, description, edit_method;
  std::uint32_t level = 0;
};

template <class Values>
std::string valueOf(const Values& values, const std::string& name) {
  for (const auto& value : values) {
    if (value.name == name) return core::formatNumber(static_cast<double>(value.value));
  }
  return "";
}

Parameter parameter(const dynamic_reconfigure::ConfigDescription& config,
                    const dynamic_reconfigure::ParamDescription& description) {
  Parameter result;
  result.type = description.type;
  result.description = description.description;
  result.edit_method = description.edit_method;
  result.level = description.level;
  const std::string& name = description.name;
  if (result.type == "int" || result.type == "double") {
    const auto pick = [&](const dynamic_reconfigure::Config& values) {
      return result.type == "int" ? valueOf(values.ints, name) : valueOf(values.doubles, name);
    };
    result.standard = pick(config.dflt);
    result.min = pick(config.min);
    result.max = pick(config.max);
  } else if (result.type == "bool") {
    result.standard = valueOf(config.dflt.bools, name) == "1" ? "true" : "false";
  } else {
    for (const auto& value : config.dflt.strs) {
      if (value.name == name) result.standard = value.value;
    }
  }
  return result;
}

std::map<std::string, Parameter> parameters(const dynamic_reconfigure::ConfigDescription& config) {
  std::map<std::string, Parameter> result;
  for (const auto& group : config.groups) {
    for (const auto& description : group.parameters)
      result[description.name] = parameter(config, description);
  }
  return result;
}

/// Compares each field of an option struct with its parameter and strikes the parameter off the list.
class Comparison : public core::OptionVisitor {
 public:
  Comparison(const core::OptionSet& options, std::map<std::string, Parameter>& open,
             const std::map<std::string, Parameter>& all, const std::string& prefix, std::uint32_t level)
      : options_(options), open_(open), all_(all), prefix_(prefix), level_(level) {}

  void field(core::OptionField field) override {
    const std::string value = field.text(options_);
    switch (field.type) {
      case core::OptionType::kNumber:
        return compareNumber(field, "double", value);
      case core::OptionType::kInteger:
        return compareNumber(field, "int", value);
      case core::OptionType::kFlag:
        compare(field.name, "bool", value, field.description);
        return;
      default:
        break;
    }
    const Parameter* found = compare(field.name, "str", value, field.description);
    if (found == nullptr) return;
    for (const auto& choice : field.choices) {
      EXPECT_NE(found->edit_method.find("'value': '" + choice.name + "'"), std::string::npos)
          << prefix_ << field.name << " does not offer " << choice.name;
    }
  }

 private:
  void compareNumber(const core::OptionField& info, const char* type, const std::string& value) {
    const Parameter* found =
        compare(info.name, type, value, info.description + (info.unit == "-" ? "" : " [" + info.unit + "]"));
    if (found == nullptr) return;
    EXPECT_EQ(found->min, core::formatNumber(info.min)) << prefix_ << info.name;
    EXPECT_EQ(found->max, core::formatNumber(info.max)) << prefix_ << info.name;
  }

  const Parameter* compare(const std::string& name, const std::string& type, const std::string& value,
                           const std::string& description) {
    const auto found = all_.find(prefix_ + name);
    if (found == all_.end()) {
      ADD_FAILURE() << "the cfg has no parameter " << prefix_ << name;
      return nullptr;
    }
    EXPECT_EQ(found->second.type, type) << prefix_ << name;
    EXPECT_EQ(found->second.standard, value) << prefix_ << name;
    EXPECT_EQ(found->second.description, description) << prefix_ << name;
    EXPECT_EQ(found->second.level, level_) << prefix_ << name;
    open_.erase(prefix_ + name);
    return &found->second;
  }

  const core::OptionSet& options_;
  std::map<std::string, Parameter>& open_;
  const std::map<std::string, Parameter>& all_;
  std::string prefix_;
  std::uint32_t level_;
};

void compare(const core::OptionSet& options, std::map<std::string, Parameter>& open,
             const std::map<std::string, Parameter>& all, const std::string& prefix, std::uint32_t level) {
  Comparison comparison(options, open, all, prefix, level);
  options.visit(comparison);
}

/// The options of a selector that are parameters: its main parameters, those that its presets set, and
/// min_confidence.
class LiveOptions : public core::OptionSet {
 public:
  explicit LiveOptions(const core::SelectorFactory& factory) : selector_(factory.create()) {
    for (const auto& entry : factory.mainParameter()) live_.insert(entry.first);
    for (const auto& preset : factory.presets()) {
      for (const auto& entry : preset.second) live_.insert(entry.first);
    }
  }

  void visit(core::OptionVisitor& visitor) const override {
    for (core::OptionField field : core::optionFields(selector_->options())) {
      if (live_.count(field.name) == 0) continue;
      field.get = [this, get = field.get](const OptionSet& /*this*/) { return get(selector_->options()); };
      visitor.field(field);
    }
  }

 private:
  std::unique_ptr<core::Selector> selector_;
  std::set<std::string> live_ = {"min_confidence"};
};

std::vector<std::string> names(const std::map<std::string, Parameter>& parameters) {
  std::vector<std::string> result;
  for (const auto& entry : parameters) result.push_back(entry.first);
  return result;
}

TEST(Cfg, SelectorParametersEqualTheOptions) {
  const auto all = parameters(SelectorConfig::__getDescriptionMessage__());
  auto open = all;
  for (const core::SelectorFactory& selector : core::builtInSelectors()) {
    const std::string& name = selector.name();
    compare(LiveOptions(selector), open, all, name + "_", 2);
    EXPECT_NE(all.at("selector").edit_method.find("'value': '" + name + "'"), std::string::npos) << name;
  }
  compare(SelectorChoice(), open, all, "", 2);
  EXPECT_EQ(names(open), std::vector<std::string>());
  EXPECT_LE(all.size(), 100u);
}

TEST(Cfg, FeatureParametersEqualTheOptions) {
  const auto all = parameters(FeatureMatcherConfig::__getDescriptionMessage__());
  auto open = all;
  for (const auto& [name, options] : liveFeatureAlgorithms()) compare(*options, open, all, name + "_", 1);
  compare(core::MatchOptions(), open, all, "match_", 2);
  compare(core::GuidedOptions(), open, all, "guided_", 2);
  compare(core::SequenceOptions(), open, all, "sequence_", 4);
  compare(core::FlowOptions(), open, all, "flow_", 16);
  for (const std::string& name : core::extractorNames()) {
    EXPECT_NE(all.at("features").edit_method.find("'value': '" + name + "'"), std::string::npos) << name;
  }
  EXPECT_EQ(names(open), (std::vector<std::string>{"features", "roi_height", "roi_width", "roi_x", "roi_y"}));
}

TEST(Cfg, MatcherParametersEqualTheOptions) {
  const auto all = parameters(MatcherConfig::__getDescriptionMessage__());
  auto open = all;
  compare(MatcherChoice(), open, all, "", MessageMatcher::kLevelMatcher);
  compare(core::MatchOptions(), open, all, "match_", MessageMatcher::kLevelMatch);
  compare(core::SequenceOptions(), open, all, "sequence_", 4);
  EXPECT_EQ(names(open), std::vector<std::string>());
}

TEST(Cfg, TrackerParametersEqualTheOptions) {
  const auto all = parameters(TrackerConfig::__getDescriptionMessage__());
  auto open = all;
  compare(TrackerChoice(), open, all, "", LiveTracker::kLevelTracker);
  EXPECT_EQ(names(open), std::vector<std::string>());
}

TEST(WriteOptions, IsReadBack) {
  SelectorConfig config = SelectorConfig::__getDefault__();
  const core::OptionMap before = readOptions(config, "lpm_"), of_gms = readOptions(config, "gms_");
  writeOptions(
      {{"tau", "0.30000000000000004"}, {"k", "9"}, {"guided", "true"}, {"cost", "multiscale"}, {"none", "1"}},
      "lpm_", config);
  EXPECT_EQ(config.lpm_tau, 0.30000000000000004);
  EXPECT_EQ(config.lpm_k, 9);
  EXPECT_TRUE(config.lpm_guided);
  EXPECT_EQ(config.lpm_cost, "multiscale");
  EXPECT_EQ(readOptions(config, "gms_"), of_gms);
  writeOptions(before, "lpm_", config);
  EXPECT_EQ(readOptions(config, "lpm_"), before);
}

TEST(ReadOptions, IncludesTheDefaults) {
  FeatureMatcherConfig config = FeatureMatcherConfig::__getDefault__();
  config.freak_pattern_scale = 11.5;
  core::OptionMap expected;
  for (const auto& [name, options] : liveFeatureAlgorithms()) {
    if (name != "freak") continue;
    for (const core::OptionText& option : core::listOptions(*options)) expected[option.name] = option.value;
  }
  expected["pattern_scale"] = "11.5";
  EXPECT_EQ(readOptions(config, "freak_"), expected);
}

}  // namespace
}  // namespace corrsel
