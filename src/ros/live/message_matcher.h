#pragma once

#include <corrsel/MatcherConfig.h>

#include <boost/shared_ptr.hpp>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>

#include "corrsel/Correspondences.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/matching/sequence.h"
#include "ros/live/feature_source.h"
#include "ros/live/frame_matching.h"

namespace corrsel {

/// Turns messages with features into messages with putative matches. The matcher follows a configuration; a
/// configuration that does not work leaves the matcher before it in force. configure() may be called while
/// match() is at work on another thread; match() is called on one thread at a time.
class MessageMatcher {
 public:
  /// Levels of the parameters in cfg/Matcher.cfg for which the matcher is made anew.
  static constexpr std::uint32_t kLevelMatcher = 1, kLevelMatch = 2;

  struct Change {
    std::string matcher;       ///< in force
    bool new_matcher = false;  ///< it was made anew
    std::string error;         ///< why the configuration is not in force; empty = it is
  };

  /// @param threads  threads that the comparison of descriptors may use; the result does not depend on it
  explicit MessageMatcher(int threads) : threads_(threads) {}

  /// Makes the matcher that a configuration asks for. Throws nothing for a bad configuration: after an error,
  /// `config` is the configuration that stays in force (at first the defaults).
  /// @param level  of the parameters that have changed, combined by "or"
  Change configure(MatcherConfig& config, std::uint32_t level);

  /// Matches the features. Only after configure(). Throws std::exception that names the field of a malformed
  /// message, features of different kinds, and what the matcher throws.
  /// @return null if there is no earlier frame yet
  boost::shared_ptr<Correspondences> match(const FeatureSet& set);

 private:
  struct Settings {
    std::shared_ptr<core::Matcher> matcher;
    core::SequenceOptions sequence;
  };

  std::shared_ptr<core::Matcher> make(const MatcherConfig& config) const;
  Settings current() const;

  const int threads_;
  std::mutex configuring_;
  MatcherConfig accepted_ = MatcherConfig::__getDefault__();  ///< the newest one that worked
  mutable std::mutex mutex_;                                  ///< guards settings_
  Settings settings_;
  std::string kind_;  ///< of the features in sequence_
  SequenceMatching sequence_;
};

}  // namespace corrsel
