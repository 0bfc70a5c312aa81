#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <ros/node_handle.h>
#include <xmlrpcpp/XmlRpcValue.h>

#include <string>
#include <vector>

#include "corrsel/options.h"

namespace corrsel {

/// Writes the raw value of a start-up parameter into its field. A value of the wrong type and a value that
/// the set's check() refuses are ignored, and the field stays as it is. A number out of range is set to the
/// nearest limit, and a number that is not whole is rounded where a whole one is expected. A list of numbers
/// is read as a text: "1, 2, 3".
/// @return what was wrong with the value, what was expected and what is used; empty = nothing was wrong
std::string assignParameter(const XmlRpc::XmlRpcValue& value, const core::OptionField& field,
                            core::OptionSet& set);

/// Reads start-up parameters: each field of the set is a parameter below `pnh`, see assignParameter(). Where
/// a value was wrong, the one in force is written back to the parameter.
/// @return one sentence for each wrong value, with name, value, what was expected and what is used
std::vector<std::string> readParameters(const ros::NodeHandle& pnh, core::OptionSet& set);

/// The reconfigure parameters of one algorithm as options of the core: the parameters whose names begin with
/// `prefix`, without it, and whose values are not the defaults. {"gms_alpha": 6.0} with the prefix "gms_"
/// gives
/// {"alpha": "6"}. Parameters with their default value are not passed on, so that the values of a preset
/// stay.
/// @param config    values in force, from the generated class's __toMessage__()
/// @param defaults  its default values, in the same form
core::OptionMap changedOptions(const dynamic_reconfigure::Config& config,
                               const dynamic_reconfigure::Config& defaults, const std::string& prefix);

/// The same with those that have their default values, for algorithms without presets.
core::OptionMap allOptions(const dynamic_reconfigure::Config& config, const std::string& prefix);

/// Reads "alpha=6,grid=10" as options. Throws std::invalid_argument that names the piece without this form.
core::OptionMap parseOptions(const std::string& text);

/// Parameters below `nh` that a dynamic_reconfigure server silently changes or ignores when it starts:
/// numbers out of range and values of the wrong type. One sentence each, with name, value and range. Must be
/// called before the server is started.
std::vector<std::string> clampedParameters(const ros::NodeHandle& nh,
                                           const dynamic_reconfigure::ConfigDescription& description);

/// clampedParameters() of a generated Config class, default ranges.
template <class Config>
std::vector<std::string> clampedParameters(const ros::NodeHandle& nh) {
  return clampedParameters(nh, Config::__getDescriptionMessage__());
}

/// allOptions() of a generated Config class.
template <class Config>
core::OptionMap allOptions(const Config& config, const std::string& prefix) {
  dynamic_reconfigure::Config values;
  config.__toMessage__(values);
  return allOptions(values, prefix);
}

/// changedOptions() of a generated Config class.
template <class Config>
core::OptionMap changedOptions(const Config& config, const std::string& prefix) {
  dynamic_reconfigure::Config values, defaults;
  config.__toMessage__(values);
  Config::__getDefault__().__toMessage__(defaults);
  return changedOptions(values, defaults, prefix);
}

}  // namespace corrsel
