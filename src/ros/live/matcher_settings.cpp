#include "ros/live/matcher_settings.h"

#include <exception>

#include "ros/live/parameters.h"

namespace corrsel {
namespace {

std::shared_ptr<const core::FeatureExtractor> createExtractor(const FeatureMatcherConfig& config) {
  core::AlgorithmOptions options;
  for (const std::string& algorithm : core::algorithmsOf(config.features)) {
    // All of them, since some default values differ from those of the library.
    options[algorithm] = readOptions(config, algorithm + "_");
  }
  return core::createExtractor(config.features, options);
}

}  // namespace

MatcherSettings::Change MatcherSettings::configure(FeatureMatcherConfig& config, std::uint32_t level) {
  const std::lock_guard<std::mutex> lock(configuring_);
  Change change;
  const std::shared_ptr<const core::FeatureExtractor> before = current().extractor;
  LiveMatcher::Settings settings;
  try {
    core::setOptions(settings.match, readOptions(config, "match_"), "match");
    core::setOptions(settings.sequence, readOptions(config, "sequence_"), "sequence");
    core::setOptions(settings.guided, readOptions(config, "guided_"), "guided");
    settings.match.check();
    settings.guided.check();
    settings.sequence.check();
    settings.area = cv::Rect(config.roi_x, config.roi_y, config.roi_width, config.roi_height);
    const bool build = !before || (level & kLevelFeatures) != 0;
    settings.extractor = build ? createExtractor(config) : before;
  } catch (const std::exception& error) {
    change.error = "not changed: " + std::string(error.what()) + "; " + accepted_.features +
                   " stays in force with the options it had";
    config = accepted_;
    if (before) {
      change.features = before->name();
      return change;
    }
    settings = {};
    settings.extractor = createExtractor(config);  // at first: the defaults
  }
  accepted_ = config;
  change.features = settings.extractor->name();
  change.new_features = settings.extractor != before;
  const std::lock_guard<std::mutex> settings_lock(mutex_);
  settings_ = settings;
  return change;
}

LiveMatcher::Settings MatcherSettings::current() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return settings_;
}

}  // namespace corrsel
