#include "ros/live/parameters.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

#include "base/text.h"

namespace corrsel {
namespace {

std::string asText(double value) { return core::formatNumber(value); }
std::string asText(int value) { return std::to_string(value); }
std::string asText(const std::string& value) { return value; }
std::string asText(bool value) { return value ? "true" : "false"; }
// Booleans travel as bytes.
std::string asText(std::uint8_t value) { return asText(value != 0); }

template <class Parameter>
const Parameter* find(const std::vector<Parameter>& parameters, const std::string& name) {
  const auto found = std::find_if(parameters.begin(), parameters.end(),
                                  [&name](const Parameter& parameter) { return parameter.name == name; });
  return found == parameters.end() ? nullptr : &*found;
}

template <class Parameter>
void addOptions(const std::vector<Parameter>& values, const std::string& prefix, core::OptionMap& options) {
  for (const Parameter& parameter : values) {
    if (parameter.name.compare(0, prefix.size(), prefix) != 0) continue;
    options[parameter.name.substr(prefix.size())] = asText(parameter.value);
  }
}

void readText(const std::string& text, const std::string& name, double& value) {
  value = core::parseNumber(text, name);
}
void readText(const std::string& text, const std::string& name, int& value) {
  value = static_cast<int>(core::parseNumber(text, name));
}
void readText(const std::string& text, const std::string& /*name*/, std::string& value) { value = text; }
void readText(const std::string& text, const std::string& /*name*/, std::uint8_t& value) {
  value = static_cast<std::uint8_t>(text == "true");
}

template <class Parameter>
void setParameters(const core::OptionMap& options, const std::string& prefix,
                   std::vector<Parameter>& parameters) {
  for (Parameter& parameter : parameters) {
    if (parameter.name.compare(0, prefix.size(), prefix) != 0) continue;
    const auto option = options.find(parameter.name.substr(prefix.size()));
    if (option != options.end()) readText(option->second, parameter.name, parameter.value);
  }
}

std::string valueText(XmlRpc::XmlRpcValue value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeInt:
      return asText(static_cast<int>(value));
    case XmlRpc::XmlRpcValue::TypeDouble:
      return asText(static_cast<double>(value));
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return asText(static_cast<bool>(value));
    case XmlRpc::XmlRpcValue::TypeString:
      return "'" + static_cast<std::string>(value) + "'";
    default:
      return "a list or a structure";
  }
}

/// What a parameter accepts.
struct Expected {
  core::OptionType type = core::OptionType::kText;
  double low = 0.0, high = 0.0;  ///< numbers and integers
  std::string range() const { return "[" + asText(low) + ", " + asText(high) + "]"; }
};

bool isNumber(const XmlRpc::XmlRpcValue& value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeInt ||
         value.getType() == XmlRpc::XmlRpcValue::TypeDouble;
}

double asNumber(XmlRpc::XmlRpcValue value) {
  return value.getType() == XmlRpc::XmlRpcValue::TypeInt ? static_cast<double>(static_cast<int>(value))
                                                         : static_cast<double>(value);
}

/// What is wrong with a parameter's raw value and what is done about it; empty = nothing.
std::string complaint(const XmlRpc::XmlRpcValue& value, const Expected& expected) {
  switch (expected.type) {
    case core::OptionType::kFlag:
      return value.getType() == XmlRpc::XmlRpcValue::TypeBoolean ? "" : "is ignored: expected true or false";
    case core::OptionType::kChoice:
    case core::OptionType::kText:
      return value.getType() == XmlRpc::XmlRpcValue::TypeString ? "" : "is ignored: expected a text";
    case core::OptionType::kInteger:
    case core::OptionType::kNumber:
      break;
  }
  if (!isNumber(value) || std::isnan(asNumber(value))) {
    return "is ignored: expected a number in " + expected.range();
  }
  const double number = asNumber(value);
  if (!(number >= expected.low && number <= expected.high)) {
    return "is outside " + expected.range() + " and is set to the nearest limit";
  }
  if (expected.type == core::OptionType::kInteger && number != std::trunc(number)) {
    return "is rounded: expected a whole number in " + expected.range();
  }
  return "";
}

Expected expectedBy(const dynamic_reconfigure::ParamDescription& parameter,
                    const dynamic_reconfigure::ConfigDescription& description) {
  Expected expected;
  if (parameter.type == "bool") expected.type = core::OptionType::kFlag;
  if (const auto* number = find(description.min.doubles, parameter.name)) {
    expected = {core::OptionType::kNumber, number->value,
                find(description.max.doubles, parameter.name)->value};
  } else if (const auto* integer = find(description.min.ints, parameter.name)) {
    expected = {core::OptionType::kInteger, static_cast<double>(integer->value),
                static_cast<double>(find(description.max.ints, parameter.name)->value)};
  }
  return expected;
}

/// A list of numbers as text, "1, 2.5"; any other value as it is.
XmlRpc::XmlRpcValue listAsText(XmlRpc::XmlRpcValue value) {
  if (value.getType() != XmlRpc::XmlRpcValue::TypeArray) return value;
  std::vector<std::string> texts;
  for (int i = 0; i < value.size(); ++i) {
    if (!isNumber(value[i])) return value;
    texts.push_back(asText(asNumber(value[i])));
  }
  return core::joinList(texts);
}

/// Writes a raw value of the right type into its field.
void assign(const core::OptionField& field, core::OptionSet& set, XmlRpc::XmlRpcValue value) {
  switch (field.type) {
    case core::OptionType::kFlag:
      field.set(set, static_cast<bool>(value));
      break;
    case core::OptionType::kNumber:
      field.set(set, std::clamp(asNumber(value), field.min, field.max));
      break;
    case core::OptionType::kInteger:
      field.set(set, static_cast<int>(std::lround(std::clamp(asNumber(value), field.min, field.max))));
      break;
    case core::OptionType::kChoice:
    case core::OptionType::kText:
      field.setText(set, static_cast<std::string>(value), "parameter " + field.name);
      break;
  }
}

}  // namespace

std::string assignParameter(const XmlRpc::XmlRpcValue& value, const core::OptionField& field,
                            core::OptionSet& set) {
  const XmlRpc::XmlRpcValue raw = field.type == core::OptionType::kText ? listAsText(value) : value;
  const core::OptionValue before = field.get(set);
  std::string text = complaint(raw, {field.type, field.min, field.max});
  if (text.find("is ignored") == std::string::npos) {
    try {
      assign(field, set, raw);
      set.check();
    } catch (const std::invalid_argument& error) {
      field.set(set, before);
      text = std::string("is ignored: ") + error.what();
    }
  }
  return text.empty() ? "" : text + "; " + field.text(set) + " is used";
}

std::vector<std::string> readParameters(const ros::NodeHandle& pnh, core::OptionSet& set) {
  std::vector<std::string> problems;
  for (const core::OptionField& field : core::optionFields(set)) {
    XmlRpc::XmlRpcValue value;
    if (!pnh.getParam(field.name, value)) continue;
    const std::string problem = assignParameter(value, field, set);
    if (problem.empty()) continue;
    problems.push_back("parameter " + pnh.resolveName(field.name) + " = " + valueText(value) + " " + problem);
    std::visit([&](const auto& used) { pnh.setParam(field.name, used); }, field.get(set));
  }
  return problems;
}

core::OptionMap readOptions(const dynamic_reconfigure::Config& config, const std::string& prefix) {
  core::OptionMap options;
  addOptions(config.doubles, prefix, options);
  addOptions(config.ints, prefix, options);
  addOptions(config.bools, prefix, options);
  addOptions(config.strs, prefix, options);
  return options;
}

void writeOptions(const core::OptionMap& options, const std::string& prefix,
                  dynamic_reconfigure::Config& config) {
  setParameters(options, prefix, config.doubles);
  setParameters(options, prefix, config.ints);
  setParameters(options, prefix, config.bools);
  setParameters(options, prefix, config.strs);
}

core::OptionMap parseOptions(const std::string& text) {
  core::OptionMap options;
  for (const std::string& piece : core::splitList(text)) {
    const std::size_t equals = piece.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw std::invalid_argument("'" + piece + "' has not the form option=value, e.g. threshold=3");
    }
    options[piece.substr(0, equals)] = piece.substr(equals + 1);
  }
  return options;
}

std::string joinOptions(const core::OptionMap& options) {
  std::vector<std::string> pieces;
  for (const auto& [name, value] : options) pieces.push_back(name + "=" + value);
  return core::joinList(pieces, ",");
}

std::vector<std::string> clampedParameters(const ros::NodeHandle& nh,
                                           const dynamic_reconfigure::ConfigDescription& description) {
  std::vector<std::string> complaints;
  for (const dynamic_reconfigure::Group& group : description.groups) {
    for (const dynamic_reconfigure::ParamDescription& parameter : group.parameters) {
      XmlRpc::XmlRpcValue value;
      if (!nh.getParam(parameter.name, value)) continue;
      const std::string text = complaint(value, expectedBy(parameter, description));
      if (!text.empty()) {
        complaints.push_back("parameter " + nh.resolveName(parameter.name) + " = " + valueText(value) + " " +
                             text);
      }
    }
  }
  return complaints;
}

}  // namespace corrsel
