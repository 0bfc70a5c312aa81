#pragma once

#include <corrsel/FeatureMatcherConfig.h>

#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "ros/live/live_matcher.h"

namespace corrsel {

/// Settings of a LiveMatcher that follow a configuration. A configuration that does not work leaves the
/// settings before it in force. Thread-safe: current() never waits for an extractor to be built.
class MatcherSettings {
 public:
  /// Levels of the parameters in cfg/FeatureMatcher.cfg: the features are built anew for the first one, and
  /// what follows points for both.
  static constexpr std::uint32_t kLevelFeatures = 1, kLevelFlow = 16;

  struct Change {
    std::string features;       ///< "detector+descriptor" or "detector+flow" in force
    bool new_features = false;  ///< the extractor, or what follows points, was built anew
    std::string error;          ///< why the configuration is not in force; empty = it is
  };

  /// @param flow  whether points are followed by optical flow
  explicit MatcherSettings(bool flow = false) : flow_(flow) {}

  /// Makes the settings that a configuration asks for. Throws nothing for a bad configuration: after an
  /// error, `config` is the configuration that stays in force (at first the defaults).
  /// @param level  of the parameters that have changed, combined by "or"
  Change configure(FeatureMatcherConfig& config, std::uint32_t level);

  /// The settings in force. Only after configure().
  LiveMatcher::Settings current() const;

 private:
  void build(const FeatureMatcherConfig& config, std::uint32_t level, LiveMatcher::Settings& settings) const;

  const bool flow_;
  std::mutex configuring_;
  FeatureMatcherConfig accepted_ = FeatureMatcherConfig::__getDefault__();  ///< the newest one that worked
  mutable std::mutex mutex_;                                                ///< guards settings_
  LiveMatcher::Settings settings_;
};

}  // namespace corrsel
