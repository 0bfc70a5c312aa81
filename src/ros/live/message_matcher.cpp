#include "ros/live/message_matcher.h"

#include <exception>
#include <stdexcept>
#include <utility>

#include "base/stopwatch.h"
#include "corrsel/ros/features.h"
#include "corrsel/ros/matcher_plugins.h"
#include "ros/live/parameters.h"

namespace corrsel {
namespace {

/// Features of different kinds cannot be compared.
std::string kindOf(const Features& message) {
  return message.features + " (descriptor_type " + std::to_string(message.descriptor_type) +
         ", descriptor_length " + std::to_string(message.descriptor_length) + ")";
}

}  // namespace

std::shared_ptr<core::Matcher> MessageMatcher::make(const MatcherConfig& config) const {
  const bool built_in = config.matcher == MatcherChoice::kDescriptors;
  std::shared_ptr<core::Matcher> matcher;
  if (built_in) {
    matcher = std::make_shared<core::DescriptorMatcher>(threads_);
  } else {
    matcher = createMatcher(config.matcher);
  }
  const core::OptionMap options = parseOptions(config.options);
  if (built_in && !options.empty()) {
    throw std::invalid_argument("options is '" + config.options +
                                "', which is for matchers of other packages; set match_mutual and "
                                "match_second_distance_radius");
  }
  matcher->configure(built_in ? readOptions(config, "match_") : options);
  return matcher;
}

MessageMatcher::Change MessageMatcher::configure(MatcherConfig& config, std::uint32_t level) {
  const std::lock_guard<std::mutex> lock(configuring_);
  Change change;
  const std::shared_ptr<core::Matcher> before = current().matcher;
  Settings settings;
  try {
    core::setOptions(settings.sequence, readOptions(config, "sequence_"), "sequence");
    settings.sequence.check();
    const bool anew = !before || (level & (kLevelMatcher | kLevelMatch)) != 0;
    settings.matcher = anew ? make(config) : before;
  } catch (const std::exception& error) {
    change.error = "not changed: " + std::string(error.what()) + "; the matcher '" + accepted_.matcher +
                   "' stays in force with the options it had";
    config = accepted_;
    change.matcher = config.matcher;
    if (before) return change;
    settings = {};
    settings.matcher = make(config);  // at first: the defaults
  }
  accepted_ = config;
  change.matcher = config.matcher;
  change.new_matcher = settings.matcher != before;
  const std::lock_guard<std::mutex> settings_lock(mutex_);
  settings_ = settings;
  return change;
}

MessageMatcher::Settings MessageMatcher::current() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return settings_;
}

boost::shared_ptr<Correspondences> MessageMatcher::match(const FeatureSet& set) {
  const Settings settings = current();
  const core::Stopwatch watch;
  FeatureInfo left_info, right_info;
  auto left = std::make_shared<core::Features>(fromMsg(*set.left, &left_info));
  PairInfo info;
  info.header = left_info.header;
  info.features = left_info.name;
  info.seconds.wait = set.waiting.seconds();
  info.seconds.detect = left_info.seconds;
  Matching matching;
  matching.match = [&settings](const FrameFeatures& from, const FrameFeatures& to, const auto&) {
    return core::GuidedMatches{settings.matcher->match(from.features, to.features)};
  };
  const std::string kind = kindOf(*set.left);
  if (!set.right) {
    if (kind != kind_) sequence_.reset();
    kind_ = kind;
    return sequence_.add(std::move(left), left_info.camera, settings.sequence, matching, watch.seconds(),
                         info);
  }
  if (kindOf(*set.right) != kind) {
    throw std::invalid_argument("the left features are " + kind + ", the right ones are " +
                                kindOf(*set.right) + "; make both in the same way");
  }
  const core::Features right = fromMsg(*set.right, &right_info);
  info.right_stamp = right_info.header.stamp;
  info.right_frame_id = right_info.header.frame_id;
  info.seconds.detect += right_info.seconds;
  return matchFrames({*left, left_info.camera}, {right, right_info.camera}, matching, watch.seconds(), info);
}

}  // namespace corrsel
