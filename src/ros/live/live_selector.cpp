#include "ros/live/live_selector.h"

#include <algorithm>
#include <boost/make_shared.hpp>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>

#include "base/spread_selection.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "corrsel/matching/match_mask.h"
#include "corrsel/motion_labels.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/pose.h"
#include "corrsel/selectors/factory.h"
#include "ros/live/image_report.h"
#include "ros/live/parameters.h"

namespace corrsel {
namespace {

std::string specOf(const SelectorConfig& config) {
  return config.preset.empty() ? config.selector : config.selector + ":" + config.preset;
}

/// The values of all options of a selector.
core::OptionMap optionsOf(const core::Selector& selector) {
  core::OptionMap values;
  for (const core::OptionText& option : core::listOptions(selector.options())) {
    values[option.name] = option.value;
  }
  return values;
}

/// Throws std::invalid_argument for options in brackets, which name and preset together have.
void refuseBrackets(const std::string& text, const SelectorConfig& config) {
  const core::SelectorSpec spec = core::SelectorSpec::fromText(text);
  if (spec.options.empty()) return;
  const std::string prefix = spec.name + "_";
  const auto& [name, value] = *spec.options.begin();
  const bool is_parameter = readOptions(config, prefix).count(name) > 0;
  throw std::invalid_argument("'" + text + "': a nodelet takes no options in brackets; set the parameter " +
                              (is_parameter ? prefix + name : "options to '" + name + "=" + value + "'"));
}

/// Makes the messages of a selection's pose, if it has one.
void addPose(const core::Selection& selection, const PairInfo& info, const std::string& spec,
             LiveSelector::Result& result) {
  if (!selection.pose) return;
  result.relative_pose = boost::make_shared<RelativePose>(toPoseMsg(selection, info, spec));
  result.verdict = core::toString(selection.pose->motion);
  const auto pose = poseOfRight(*result.relative_pose);
  if (pose) result.pose = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>(*pose);
}

/// The matches that masks leave, and what became of the masks.
struct Unmasked {
  std::vector<std::uint32_t> rows;
  std::uint8_t mask_use = Selection::MASK_UNUSED;
  std::string warning;  ///< why a mask was left out; empty = none was
};

Unmasked unmasked(const core::Correspondences& matches, PairMasks masks) {
  Unmasked result;
  const auto fit = [&](cv::Mat& mask, const cv::Size& image, const std::string& side) {
    try {
      if (!mask.empty()) mask = core::fittedMask(mask, image);
    } catch (const std::invalid_argument& error) {
      result.warning = side + " " + error.what();
      mask.release();
      masks.missing = true;
    }
  };
  fit(masks.left, matches.left_size, "left");
  fit(masks.right, matches.right_size, "right");
  result.rows = core::unmaskedRows(matches, masks.left, masks.right);
  result.mask_use = masks.missing ? Selection::MASK_MISSING : Selection::MASK_APPLIED;
  return result;
}

/// Selects, and adds what the selector leaves to others: the confidence, and where asked for what moves.
core::Selection selectAndExplain(const core::Selector& selector, bool label_motion,
                                 const core::Correspondences& matches) {
  core::Selection selection = selector.select(matches);
  addConfidence(matches, selection);
  if (label_motion) core::labelMotion(matches, selection);
  return selection;
}

/// Why there is nothing to select from, as far as the images explain it.
std::string noMatches(const Correspondences& message, const std::string& faults) {
  const std::string text = "no putative matches: ";
  if (!faults.empty()) return text + faults;
  if (std::isnan(message.left_quality.black)) return text + "are the images dark, blurred or masked?";
  return text + "the images are neither dark, overexposed, blurred nor noisy; are they masked?";
}

/// 0 for times that were not measured, because somebody else has made the matches.
double orZero(double seconds) { return seconds >= 0 ? seconds : 0.0; }

}  // namespace

LiveSelector::LiveSelector(const std::string& presets) {
  for (const std::string& text : core::splitList(presets)) {
    try {
      const core::SelectorSpec spec = core::SelectorSpec::fromText(text);
      writeOptions(optionsOf(*core::createSelector(text)), spec.name + "_", accepted_);
      presets_[spec.name] = spec.preset.value_or("");
    } catch (const std::invalid_argument&) {
      // Another version of the package, which had this preset, has set the parameters.
    }
  }
}

/// The values of the chosen selector's parameters. Where they belong to another preset, those that have not
/// changed since the last configuration get the values of the chosen one.
core::OptionMap LiveSelector::parametersOf(const SelectorConfig& config) const {
  const std::string prefix = config.selector + "_";
  core::OptionMap values = readOptions(config, prefix);
  const auto written = presets_.find(config.selector);
  if (values.empty() || config.preset == (written == presets_.end() ? "" : written->second)) return values;
  const core::OptionMap before = readOptions(accepted_, prefix);
  const core::OptionMap preset = optionsOf(*core::createSelector(specOf(config)));
  for (auto& [name, value] : values) {
    if (value == before.at(name)) value = preset.at(name);
  }
  return values;
}

/// Makes the selector of a configuration, and writes into the configuration the options that it has.
LiveSelector::Active LiveSelector::create(SelectorConfig& config) const {
  Active active;
  active.spec = specOf(config);
  refuseBrackets(active.spec, config);
  active.max_seconds = config.max_seconds;
  active.label_motion = config.label_motion;
  core::OptionMap options = parametersOf(config), others;
  for (const auto& [name, value] : parseOptions(config.options)) {
    if (options.count(name) == 0) others[name] = value;
    options[name] = value;
  }
  core::OptionMap common = {{"seed", std::to_string(config.seed)}};
  if (config.max_seconds > 0) {
    common["max_seconds"] = core::formatNumber(config.max_seconds);
    // The selector's own limit counts only where it is the stricter one.
    const auto own = options.find("max_seconds");
    const double limit = own == options.end() ? 0.0 : core::parseNumber(own->second, "max_seconds");
    if (own != options.end() && (limit <= 0 || limit > config.max_seconds)) options.erase(own);
  }
  active.selector = core::createSelector(active.spec, options, common);
  writeOptions(optionsOf(*active.selector), config.selector + "_", config);
  config.options = joinOptions(others);
  return active;
}

/// Clears a preset and options that belong to the previous selector.
/// @return what was done
std::vector<std::string> LiveSelector::clearLeftovers(SelectorConfig& config) const {
  std::vector<std::string> done;
  if (config.selector == accepted_.selector) return done;
  if (!config.options.empty() && config.options == accepted_.options) {
    done.push_back("options '" + config.options + "' are those of " + accepted_.selector +
                   " and are cleared");
    config.options.clear();
  }
  if (!config.preset.empty() && config.preset == accepted_.preset) {
    const std::vector<std::string> presets = core::selectorPresets(config.selector);
    if (std::find(presets.begin(), presets.end(), config.preset) == presets.end()) {
      done.push_back("preset '" + config.preset + "' is not one of " + config.selector + "'s and is cleared");
      config.preset.clear();
    }
  }
  return done;
}

LiveSelector::Change LiveSelector::configure(SelectorConfig& config) {
  const std::lock_guard<std::mutex> lock(configuring_);
  Change change;
  Active active;
  try {
    change.warnings = clearLeftovers(config);
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
  presets_[config.selector] = config.preset;
  change.spec = active.spec;
  const std::lock_guard<std::mutex> active_lock(active_mutex_);
  active_ = active;
  return change;
}

std::string LiveSelector::presets() const {
  const std::lock_guard<std::mutex> lock(configuring_);
  std::vector<std::string> specs;
  for (const auto& [selector, preset] : presets_) {
    if (!preset.empty()) specs.push_back(selector + ":" + preset);
  }
  return core::joinList(specs, ",");
}

std::vector<std::string> unreadParameters(const std::vector<std::string>& names) {
  std::vector<std::string> complaints;
  if (std::find(names.begin(), names.end(), "plugin_options") != names.end()) {
    complaints.push_back("parameter plugin_options is not read; set the parameter options");
  }
  for (const std::string& selector : core::selectorNames()) {
    const std::string prefix = selector + "_";
    const core::OptionMap parameters = readOptions(SelectorConfig::__getDefault__(), prefix);
    for (const auto& [option, value] : optionsOf(*core::createSelector(selector))) {
      const bool is_given = std::find(names.begin(), names.end(), prefix + option) != names.end();
      if (!is_given || parameters.count(option) > 0) continue;
      complaints.push_back("parameter " + prefix + option +
                           " is not read; set the parameter options, e.g. '" + option + "=" + value + "'");
    }
  }
  // Those of corrsel::reference are loaded at run time, so their options have no parameters at all.
  for (const std::string& name : names) {
    for (std::size_t at = name.find('_'); at != std::string::npos; at = name.find('_', at + 1)) {
      if (!core::isReferenceName(name.substr(0, at))) continue;
      complaints.push_back("parameter " + name + " is not read; set the parameter options, e.g. '" +
                           name.substr(at + 1) + "=VALUE'");
    }
  }
  return complaints;
}

LiveSelector::Result LiveSelector::select(const Correspondences& message, double waited,
                                          const std::optional<PairMasks>& masks) const {
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

  watch.restart();
  const Unmasked rest = masks ? unmasked(input, *masks) : Unmasked();
  const std::size_t n_masked = masks ? input.size() - rest.rows.size() : 0;
  const auto chosen = [&active](const core::Correspondences& matches) {
    return selectAndExplain(*active.selector, active.label_motion, matches);
  };
  const core::Selection selection =
      n_masked == 0 ? chosen(input)
                    : core::spreadSelection(chosen(input.subset(rest.rows)), rest.rows, input.size());
  info.seconds.select = selection.seconds;
  Result result;
  // Subscribers of the matches alone see no status: they get none that they should not rely on.
  const bool reliable = selection.status != core::Status::kUncertain;
  const std::vector<std::uint32_t> rows =
      reliable ? core::selectedRows(selection.mask) : std::vector<std::uint32_t>();
  result.matches = boost::make_shared<Correspondences>(toMsg(input.subset(rows), info));
  if (active.label_motion) {
    const core::Correspondences moving = input.subset(core::movingRows(selection));
    result.moving = boost::make_shared<Correspondences>(toMsg(moving, info));
  }
  result.selection = boost::make_shared<Selection>(toMsg(selection, info, active.spec));
  result.selection->mask_use = rest.mask_use;
  result.selection->n_masked = static_cast<std::uint32_t>(n_masked);
  addPose(selection, info, active.spec, result);
  result.selection->seconds.publish += watch.seconds() - selection.seconds;

  if (selection.n_input == 0) {
    result.warning = noMatches(message, imageFaults(message));
  } else if (selection.status != core::Status::kOk) {
    result.warning = active.spec + ": " + core::toString(selection.status) + ": " + selection.message;
    const std::string faults = imageFaults(message);
    if (!faults.empty()) result.warning += "; " + faults;
  } else if (active.max_seconds > 0 && selection.seconds > active.max_seconds) {
    result.warning = active.spec + ": took " + core::formatNumber(selection.seconds) +
                     " s of max_seconds = " + core::formatNumber(active.max_seconds) + " with " +
                     std::to_string(selection.n_input) + " matches";
  } else if (selection.guess == core::GuessVerdict::kContradicted) {
    result.warning = active.spec + ": the matches show another motion than was known before (prior)";
  }
  if (!rest.warning.empty()) {
    result.warning = rest.warning + (result.warning.empty() ? "" : "; " + result.warning);
  }
  return result;
}

}  // namespace corrsel
