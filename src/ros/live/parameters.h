#pragma once

#include <dynamic_reconfigure/Config.h>
#include <dynamic_reconfigure/ConfigDescription.h>
#include <ros/node_handle.h>

#include <string>
#include <vector>

#include "corrsel/options.h"

namespace corrsel {

/// The reconfigure parameters of one algorithm as options of the core: those whose name begins with `prefix`,
/// without it, and whose value is not the default: {"gms_alpha": 6.0} with prefix "gms_" gives {"alpha":
/// "6"}. Parameters left at their default are not passed on, so that the values of a preset stand.
/// @param config    values in force, from the generated class's __toMessage__()
/// @param defaults  its default values, in the same form
core::OptionMap changedOptions(const dynamic_reconfigure::Config& config,
                               const dynamic_reconfigure::Config& defaults, const std::string& prefix);

/// Reads the parameters below `nh` that `parameters` describes; those that are not set keep their value.
/// Numbers out of range become the nearest limit, and values of another type are ignored.
/// @return one sentence for each value that was changed or ignored, with its name, value and range
/// Throws std::invalid_argument for a choice that does not exist, naming parameter, value and valid names:
/// what the user wanted cannot be guessed.
std::vector<std::string> readParameters(const ros::NodeHandle& nh, core::OptionSet& parameters);

/// "alpha=6,grid=10" as options. Throws std::invalid_argument naming the piece that does not read so.
core::OptionMap parseOptions(const std::string& text);

/// Parameters below `nh` that a dynamic_reconfigure server is going to change or ignore without a word when
/// it starts: numbers out of range, values of the wrong type, choices that do not exist. One sentence each,
/// with name, value and range. To be called before the server is started.
std::vector<std::string> clampedParameters(const ros::NodeHandle& nh,
                                           const dynamic_reconfigure::ConfigDescription& description);

/// clampedParameters() of a generated Config class, default ranges.
template <class Config>
std::vector<std::string> clampedParameters(const ros::NodeHandle& nh) {
  return clampedParameters(nh, Config::__getDescriptionMessage__());
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
