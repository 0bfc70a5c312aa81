#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "corrsel/Features.h"
#include "ros/live/live_source.h"
#include "ros/live/nodelet_parameters.h"

namespace corrsel {

/// Features that are matched with each other, as they arrived.
struct FeatureSet {
  FeaturesConstPtr left;    ///< in sequence mode: of the newest image
  FeaturesConstPtr right;   ///< null in sequence mode
  core::Stopwatch waiting;  ///< started when the set was complete
};

/// Brings `left/features` and `right/features` together by their stamps, or hands over every message of
/// `features` in sequence mode. A message is paired with the first one of the other side whose stamp differs
/// by at most `max_interval`, and what is older than a pair is dropped. When the stamps of a side go
/// backwards (a bag that is played in a loop), all waiting messages are dropped.
///
/// The callback is called on the queue of the node handle, which must call one callback at a time.
class FeatureSource : public LiveSource {
 public:
  using Callback = std::function<void(FeatureSet)>;

  /// Does not subscribe yet.
  FeatureSource(const ros::NodeHandle& nh, const MatcherParameters& parameters, Callback on_set);

  void subscribe() override;
  void unsubscribe() override;
  std::vector<std::string> topics() const override;
  Inputs inputs() const override;

  /// Why both sides have brought messages since the previous call, but no pair, with the remedies.
  std::string complaint() override;

 private:
  /// What one topic brings.
  struct Side {
    std::string topic;
    ros::Subscriber subscriber;
    std::atomic<std::size_t> received{0};
    std::size_t received_before = 0;       ///< at the previous complaint
    std::deque<FeaturesConstPtr> waiting;  ///< without a partner, oldest first
    ros::Time newest;                      ///< stamp of the newest message
  };

  void receive(std::size_t side, const FeaturesConstPtr& message);
  void pair(std::size_t side, const FeaturesConstPtr& message);

  ros::NodeHandle nh_;
  const bool sequence_;
  const ros::Duration max_interval_;
  const std::uint32_t subscriber_queue_size_;
  const std::size_t queue_size_;
  const Callback on_set_;
  std::atomic<std::size_t> n_sets_{0};
  std::atomic<double> difference_{
      0};                    ///< of the stamps of a message and the nearest one of the other side, s
  std::mutex period_mutex_;  ///< one complaint() at a time
  std::size_t n_sets_before_ = 0;
  std::array<Side, 2> sides_;  ///< left, right; in sequence mode the first one alone
};

}  // namespace corrsel
