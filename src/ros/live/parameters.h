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
/// `prefix`, without it. {"gms_alpha": 6.0} with the prefix "gms_" gives {"alpha": "6"}.
/// @param config  values in force, from the generated class's __toMessage__()
core::OptionMap readOptions(const dynamic_reconfigure::Config& config, const std::string& prefix);

/// The reverse: sets the parameters whose names are `prefix` and the name of one of the options. Options
/// without a parameter are skipped. Throws std::invalid_argument for a text that is not a number where the
/// parameter is one.
void writeOptions(const core::OptionMap& options, const std::string& prefix,
                  dynamic_reconfigure::Config& config);

/// Reads "alpha=6,grid=10" as options. Throws std::invalid_argument that names the piece without this form.
core::OptionMap parseOptions(const std::string& text);

/// The reverse of parseOptions().
std::string joinOptions(const core::OptionMap& options);

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

/// readOptions() of a generated Config class.
template <class Config>
core::OptionMap readOptions(const Config& config, const std::string& prefix) {
  dynamic_reconfigure::Config values;
  config.__toMessage__(values);
  return readOptions(values, prefix);
}

/// writeOptions() of a generated Config class.
template <class Config>
void writeOptions(const core::OptionMap& options, const std::string& prefix, Config& config) {
  dynamic_reconfigure::Config values;
  config.__toMessage__(values);
  writeOptions(options, prefix, values);
  config.__fromMessage__(values);
}

}  // namespace corrsel
