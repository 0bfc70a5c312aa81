#include "ros/live/matcher_settings.h"

#include <exception>

#include "ros/live/parameters.h"

namespace corrsel {
namespace {

/// The options of the algorithms of a combination. All of them, since some default values differ from those
/// of the library.
core::AlgorithmOptions optionsOf(const std::string& features, const FeatureMatcherConfig& config) {
  core::AlgorithmOptions options;
  options[core::kImageOptions] = readOptions(config, core::kImageOptions + std::string("_"));
  for (const std::string& algorithm : core::algorithmsOf(features)) {
    options[algorithm] = readOptions(config, algorithm + "_");
  }
  return options;
}

std::shared_ptr<core::FlowMatcher> createFlow(const FeatureMatcherConfig& config) {
  core::FlowOptions options;
  core::setOptions(options, readOptions(config, "flow_"), "flow");
  return std::make_shared<core::FlowMatcher>(options, optionsOf(options.detector, config));
}

std::string nameOf(const LiveMatcher::Settings& settings) {
  return settings.flow ? settings.flow->name() : settings.extractor->name();
}

}  // namespace

/// Builds what the levels ask for, and all that is not there yet.
void MatcherSettings::build(const FeatureMatcherConfig& config, std::uint32_t level,
                            LiveMatcher::Settings& settings) const {
  if (!settings.extractor || (level & kLevelFeatures) != 0) {
    settings.extractor = core::createExtractor(config.features, optionsOf(config.features, config));
  }
  if (flow_ && (!settings.flow || (level & (kLevelFeatures | kLevelFlow)) != 0)) {
    settings.flow = createFlow(config);
  }
}

MatcherSettings::Change MatcherSettings::configure(FeatureMatcherConfig& config, std::uint32_t level) {
  const std::lock_guard<std::mutex> lock(configuring_);
  Change change;
  const LiveMatcher::Settings before = current();
  LiveMatcher::Settings settings;
  settings.extractor = before.extractor;
  settings.flow = before.flow;
  try {
    core::setOptions(settings.match, readOptions(config, "match_"), "match");
    core::setOptions(settings.sequence, readOptions(config, "sequence_"), "sequence");
    core::setOptions(settings.guided, readOptions(config, "guided_"), "guided");
    settings.match.check();
    settings.guided.check();
    settings.sequence.check();
    settings.area = cv::Rect(config.roi_x, config.roi_y, config.roi_width, config.roi_height);
    build(config, level, settings);
  } catch (const std::exception& error) {
    config = accepted_;
    settings = {};
    if (!before.extractor) build(config, level, settings);  // at first: the defaults
    change.features = nameOf(before.extractor ? before : settings);
    change.error = "not changed: " + std::string(error.what()) + "; " + change.features +
                   " stays in force with the options it had";
    if (before.extractor) return change;
  }
  accepted_ = config;
  change.features = nameOf(settings);
  change.new_features = settings.extractor != before.extractor || settings.flow != before.flow;
  const std::lock_guard<std::mutex> settings_lock(mutex_);
  settings_ = settings;
  return change;
}

LiveMatcher::Settings MatcherSettings::current() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return settings_;
}

}  // namespace corrsel
