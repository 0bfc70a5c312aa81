#include "ros/live/feature_source.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "base/text.h"

namespace corrsel {

FeatureSource::FeatureSource(const ros::NodeHandle& nh, const MatcherParameters& parameters, Callback on_set)
    : nh_(nh),
      sequence_(parameters.mode == FeatureMode::kSequence),
      max_interval_(parameters.max_interval),
      subscriber_queue_size_(static_cast<std::uint32_t>(parameters.subscriber_queue_size)),
      queue_size_(static_cast<std::size_t>(parameters.queue_size)),
      on_set_(std::move(on_set)) {
  sides_[0].topic = sequence_ ? "features" : "left/features";
  if (!sequence_) sides_[1].topic = "right/features";
}

void FeatureSource::subscribe() {
  for (std::size_t side = 0; side < sides_.size(); ++side) {
    if (sides_[side].topic.empty()) continue;
    sides_[side].subscriber =
        nh_.subscribe<Features>(sides_[side].topic, subscriber_queue_size_,
                                [this, side](const FeaturesConstPtr& message) { receive(side, message); });
  }
}

void FeatureSource::unsubscribe() {
  for (Side& side : sides_) side.subscriber.shutdown();
  for (Side& side : sides_) side.waiting.clear();
}

std::vector<std::string> FeatureSource::topics() const {
  std::vector<std::string> names;
  for (const Side& side : sides_) {
    if (!side.topic.empty()) names.push_back(nh_.resolveName(side.topic));
  }
  return names;
}

LiveSource::Inputs FeatureSource::inputs() const {
  Inputs inputs;
  for (const Side& side : sides_) {
    if (!side.topic.empty()) inputs.emplace_back(side.topic, side.received);
  }
  return inputs;
}

void FeatureSource::receive(std::size_t side, const FeaturesConstPtr& message) {
  ++sides_[side].received;
  if (!sequence_) return pair(side, message);
  ++n_sets_;
  on_set_({message, nullptr, core::Stopwatch()});
}

void FeatureSource::pair(std::size_t side, const FeaturesConstPtr& message) {
  Side &own = sides_[side], &other = sides_[1 - side];
  const ros::Time stamp = message->header.stamp;
  if (stamp < own.newest) {
    for (Side& each : sides_) {
      each.waiting.clear();
      each.newest = ros::Time();
    }
  }
  own.newest = stamp;
  const auto difference = [&stamp](const FeaturesConstPtr& waiting) {
    return std::abs((waiting->header.stamp - stamp).toSec());
  };
  const auto partner =
      std::min_element(other.waiting.begin(), other.waiting.end(),
                       [&](const auto& a, const auto& b) { return difference(a) < difference(b); });
  if (partner != other.waiting.end()) difference_ = difference(*partner);
  if (partner == other.waiting.end() || difference(*partner) > max_interval_.toSec()) {
    own.waiting.push_back(message);
    if (own.waiting.size() > queue_size_) own.waiting.pop_front();
    return;
  }
  const FeaturesConstPtr found = *partner;
  other.waiting.erase(other.waiting.begin(), partner + 1);
  own.waiting.clear();
  ++n_sets_;
  const bool left = side == 0;
  on_set_({left ? message : found, left ? found : message, core::Stopwatch()});
}

std::string FeatureSource::complaint() {
  const std::lock_guard<std::mutex> lock(period_mutex_);
  const std::size_t sets = n_sets_ - n_sets_before_;
  n_sets_before_ += sets;
  std::array<std::size_t, 2> received{};
  for (std::size_t side = 0; side < sides_.size(); ++side) {
    received[side] = sides_[side].received - sides_[side].received_before;
    sides_[side].received_before += received[side];
  }
  if (sequence_ || sets > 0 || received[0] == 0 || received[1] == 0) return "";
  return std::to_string(received[0]) + " messages on " + nh_.resolveName(sides_[0].topic) + " and " +
         std::to_string(received[1]) + " on " + nh_.resolveName(sides_[1].topic) +
         " form no pair: their stamps differ by " + core::formatNumber(difference_) +
         " s; give both the stamp of the images, or raise ~max_interval (" +
         core::formatNumber(max_interval_.toSec()) + " s) or ~queue_size";
}

}  // namespace corrsel
