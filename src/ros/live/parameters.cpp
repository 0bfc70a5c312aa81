#include "ros/live/parameters.h"

#include <xmlrpcpp/XmlRpcValue.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

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
void addChanged(const std::vector<Parameter>& values, const std::vector<Parameter>& defaults,
                const std::string& prefix, core::OptionMap& options) {
  for (const Parameter& parameter : values) {
    if (parameter.name.compare(0, prefix.size(), prefix) != 0) continue;
    const Parameter* standard = find(defaults, parameter.name);
    if (standard != nullptr && standard->value == parameter.value) continue;
    options[parameter.name.substr(prefix.size())] = asText(parameter.value);
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

std::string numberRange(const dynamic_reconfigure::ConfigDescription& description, const std::string& name,
                        double& low, double& high) {
  if (const auto* parameter = find(description.min.doubles, name)) {
    low = parameter->value;
    high = find(description.max.doubles, name)->value;
  } else if (const auto* integer = find(description.min.ints, name)) {
    low = integer->value;
    high = find(description.max.ints, name)->value;
  }
  return "[" + asText(low) + ", " + asText(high) + "]";
}

/// What is wrong with a parameter's raw value, or an empty text.
std::string complaint(XmlRpc::XmlRpcValue value, const dynamic_reconfigure::ParamDescription& parameter,
                      const dynamic_reconfigure::ConfigDescription& description) {
  const auto type = value.getType();
  if (parameter.type == "bool") {
    return type == XmlRpc::XmlRpcValue::TypeBoolean ? "" : "is ignored: expected true or false";
  }
  if (parameter.type == "str") {
    return type == XmlRpc::XmlRpcValue::TypeString ? "" : "is ignored: expected a text";
  }
  if (type != XmlRpc::XmlRpcValue::TypeInt && type != XmlRpc::XmlRpcValue::TypeDouble) {
    return "is ignored: expected a number";
  }
  const double number = type == XmlRpc::XmlRpcValue::TypeInt ? static_cast<double>(static_cast<int>(value))
                                                             : static_cast<double>(value);
  double low = 0.0, high = 0.0;
  const std::string range = numberRange(description, parameter.name, low, high);
  if (!(number >= low && number <= high)) return "is outside " + range + " and is set to the nearest limit";
  if (parameter.type == "int" && number != static_cast<double>(static_cast<int>(number))) {
    return "is rounded: expected a whole number in " + range;
  }
  return "";
}

}  // namespace

core::OptionMap changedOptions(const dynamic_reconfigure::Config& config,
                               const dynamic_reconfigure::Config& defaults, const std::string& prefix) {
  core::OptionMap options;
  addChanged(config.doubles, defaults.doubles, prefix, options);
  addChanged(config.ints, defaults.ints, prefix, options);
  addChanged(config.bools, defaults.bools, prefix, options);
  addChanged(config.strs, defaults.strs, prefix, options);
  return options;
}

std::vector<std::string> readParameters(const ros::NodeHandle& nh, core::OptionSet& parameters) {
  std::vector<std::string> complaints;
  for (const core::OptionField& field : core::optionFields(parameters)) {
    XmlRpc::XmlRpcValue value;
    if (!nh.getParam(field.name, value)) continue;
    const std::string what = "parameter " + nh.resolveName(field.name) + " = " + valueText(value) + " ";
    const auto ignore = [&](const char* expected) {
      complaints.push_back(what + "is ignored: expected " + expected);
    };
    const auto type = value.getType();
    if (field.type == core::OptionType::kFlag) {
      if (type != XmlRpc::XmlRpcValue::TypeBoolean) {
        ignore("true or false");
      } else {
        field.set(parameters, static_cast<bool>(value));
      }
    } else if (field.type == core::OptionType::kText || field.type == core::OptionType::kChoice) {
      if (type != XmlRpc::XmlRpcValue::TypeString) {
        ignore("a text");
      } else {
        field.setText(parameters, static_cast<std::string>(value), "parameter " + nh.resolveName(field.name));
      }
    } else if (type != XmlRpc::XmlRpcValue::TypeInt && type != XmlRpc::XmlRpcValue::TypeDouble) {
      ignore("a number");
    } else {
      const double number = type == XmlRpc::XmlRpcValue::TypeInt
                                ? static_cast<double>(static_cast<int>(value))
                                : static_cast<double>(value);
      const double nearest = number >= field.min ? std::min(number, field.max) : field.min;
      if (nearest != number)
        complaints.push_back(what + "is outside " + field.range() + " and is set to the nearest limit");
      if (field.type == core::OptionType::kNumber) {
        field.set(parameters, nearest);
      } else {
        if (nearest != std::trunc(nearest))
          complaints.push_back(what + "is rounded: expected a whole number in " + field.range());
        field.set(parameters, static_cast<int>(nearest));
      }
    }
  }
  return complaints;
}

core::OptionMap parseOptions(const std::string& text) {
  core::OptionMap options;
  for (const std::string& piece : core::splitList(text)) {
    const std::size_t equals = piece.find('=');
    if (equals == std::string::npos || equals == 0) {
      throw std::invalid_argument("'" + piece + "' does not read as option=value, e.g. threshold=3");
    }
    options[piece.substr(0, equals)] = piece.substr(equals + 1);
  }
  return options;
}

std::vector<std::string> clampedParameters(const ros::NodeHandle& nh,
                                           const dynamic_reconfigure::ConfigDescription& description) {
  std::vector<std::string> complaints;
  for (const dynamic_reconfigure::Group& group : description.groups) {
    for (const dynamic_reconfigure::ParamDescription& parameter : group.parameters) {
      XmlRpc::XmlRpcValue value;
      if (!nh.getParam(parameter.name, value)) continue;
      const std::string text = complaint(value, parameter, description);
      if (!text.empty()) {
        complaints.push_back("parameter " + nh.resolveName(parameter.name) + " = " + valueText(value) + " " +
                             text);
      }
    }
  }
  return complaints;
}

}  // namespace corrsel
