#include "ros/live/live_selector.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <exception>

#include "base/stopwatch.h"
#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/selectors/factory.h"
#include "ros/live/parameters.h"

namespace corrsel {
namespace {

std::string specOf(const SelectorConfig& config) {
  return config.preset.empty() ? config.selector : config.selector + ":" + config.preset;
}

/// Whether the selector may be a plug-in, whose options are the text of the parameter `plugin_options`.
/// Throws what core::findSelector() throws.
bool hasPluginOptions(const std::string& name) {
  const core::SelectorGroup group = core::findSelector(name).group();
  return group == core::SelectorGroup::kReference || group == core::SelectorGroup::kOtherPackage;
}

/// 0 for times that were not measured, because somebody else has made the matches.
double orZero(double seconds) { return seconds >= 0 ? seconds : 0.0; }

}  // namespace

LiveSelector::Active LiveSelector::create(const SelectorConfig& config) {
  Active active;
  active.spec = specOf(config);
  const core::SelectorSpec spec = core::SelectorSpec::fromText(active.spec);
  if (!spec.options.empty()) {
    const std::string& option = spec.options.begin()->first;
    throw std::invalid_argument("'" + active.spec +
                                "': a nodelet takes no options in brackets; set the parameter " +
                                (hasPluginOptions(spec.name) ? "plugin_options" : spec.name + "_" + option));
  }
  active.max_seconds = config.max_seconds;
  core::OptionMap options = hasPluginOptions(config.selector) ? parseOptions(config.plugin_options)
                                                              : changedOptions(config, config.selector + "_");
  core::OptionMap common = {{"seed", std::to_string(config.seed)}};
  if (config.max_seconds > 0) {
    common["max_seconds"] = core::formatNumber(config.max_seconds);
    // The selector's own limit counts only where it is the stricter one.
    const auto own = options.find("max_seconds");
    const double limit = own == options.end() ? 0.0 : core::parseNumber(own->second, "max_seconds");
    if (own != options.end() && (limit <= 0 || limit > config.max_seconds)) options.erase(own);
  }
  active.selector = core::createSelector(active.spec, options, common);
  return active;
}

/// Clears a preset that belongs to the previous selector.
/// @return what was done; empty = nothing
std::string LiveSelector::clearStalePreset(SelectorConfig& config) const {
  if (config.preset.empty() || config.selector == accepted_.selector || config.preset != accepted_.preset) {
    return "";
  }
  const std::vector<std::string> presets = core::selectorPresets(config.selector);
  if (std::find(presets.begin(), presets.end(), config.preset) != presets.end()) return "";
  const std::string preset = config.preset;
  config.preset.clear();
  return "preset '" + preset + "' is not one of " + config.selector + "'s and is cleared";
}

LiveSelector::Change LiveSelector::configure(SelectorConfig& config) {
  const std::lock_guard<std::mutex> lock(configuring_);
  Change change;
  Active active;
  try {
    const std::string cleared = clearStalePreset(config);
    if (!cleared.empty()) change.warnings.push_back(cleared);
    active = create(config);
  } catch (const std::exception& error) {
    change.error = "selector not changed: " + std::string(error.what()) + "; '" + specOf(accepted_) +
                   "' stays in force with the options it had";
    config = accepted_;
    change.spec = specOf(accepted_);
    if (active_.selector) return change;
    active = create(config);  // at first: the defaults
  }
  accepted_ = config;
  change.spec = active.spec;
  const std::lock_guard<std::mutex> active_lock(active_mutex_);
  active_ = active;
  return change;
}

LiveSelector::Result LiveSelector::select(const Correspondences& message, double waited) const {
  Active active;
  {
    const std::lock_guard<std::mutex> lock(active_mutex_);
    active = active_;
  }
  core::Stopwatch watch;
  PairInfo info;
  const core::Correspondences input = fromMsg(message, &info);
  info.seconds.wait = orZero(info.seconds.wait) + waited;
  info.seconds.publish = orZero(info.seconds.publish) + watch.seconds();

  core::Selection selection = active.selector->select(input);
  info.seconds.select = selection.seconds;
  watch.restart();
  addConfidence(input, selection);
  Result result;
  // Subscribers of the matches alone see no status: they get none that they should not rely on.
  const bool reliable = selection.status != core::Status::kUncertain;
  const std::vector<std::uint32_t> rows =
      reliable ? core::selectedRows(selection.mask) : std::vector<std::uint32_t>();
  result.matches = boost::make_shared<Correspondences>(toMsg(input.subset(rows), info));
  result.selection = boost::make_shared<Selection>(toMsg(selection, info, active.spec));
  result.selection->seconds.publish += watch.seconds();

  if (selection.n_input == 0) {
    result.warning = "no putative matches: are the images dark, blurred or masked?";
  } else if (selection.status != core::Status::kOk) {
    result.warning = active.spec + ": " + core::toString(selection.status) + ": " + selection.message;
  } else if (active.max_seconds > 0 && selection.seconds > active.max_seconds) {
    result.warning = active.spec + ": took " + core::formatNumber(selection.seconds) +
                     " s of max_seconds = " + core::formatNumber(active.max_seconds) + " with " +
                     std::to_string(selection.n_input) + " matches";
  }
  return result;
}

}  // namespace corrsel
