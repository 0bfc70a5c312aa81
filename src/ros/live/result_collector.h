#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <sensor_msgs/Image.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

#include "corrsel/Correspondences.h"
#include "corrsel/GroundTruth.h"
#include "corrsel/Selection.h"
#include "ros/live/stamp_cache.h"

namespace corrsel {

/// Brings together what was published about one image pair: the messages of `correspondences`, `selection`
/// and `ground_truth` that have one stamp. They may come in any order. Not thread-safe: everything is called
/// on the queue of the node handle, which must call one callback at a time.
class ResultCollector {
 public:
  /// What has arrived for one stamp.
  struct Result {
    CorrespondencesConstPtr correspondences;
    GroundTruthConstPtr truth;
    std::vector<SelectionConstPtr> selections;  ///< of several selectors; removed after use
    sensor_msgs::ImageConstPtr left;            ///< filled if needed
  };
  using Callback = std::function<void(Result&)>;

  /// @param capacity  stamps that are remembered. @param on_change  called after every message
  ResultCollector(std::size_t capacity, Callback on_change)
      : results_(capacity), on_change_(std::move(on_change)) {}

  /// @param queue_size  messages of each topic that wait to be taken over
  void subscribe(const ros::NodeHandle& nh, std::uint32_t queue_size) {
    add<GroundTruth>(nh, "ground_truth", queue_size,
                     [](Result& result, const GroundTruthConstPtr& message) { result.truth = message; });
    add<Correspondences>(
        nh, "correspondences", queue_size,
        [](Result& result, const CorrespondencesConstPtr& message) { result.correspondences = message; });
    add<Selection>(nh, "selection", queue_size, [](Result& result, const SelectionConstPtr& message) {
      result.selections.push_back(message);
    });
  }

  void unsubscribe() { subscribers_.clear(); }

  /// What has arrived for this stamp, or an empty result. The reference holds until the next message.
  Result& at(const ros::Time& stamp) { return results_[stamp]; }

  /// The results of the newest stamps.
  auto begin() { return results_.begin(); }
  auto end() { return results_.end(); }

 private:
  template <class Message, class Take>
  void add(ros::NodeHandle nh, const char* topic, std::uint32_t queue_size, Take take) {
    using MessagePtr = boost::shared_ptr<const Message>;
    subscribers_.push_back(nh.subscribe<Message>(topic, queue_size, [this, take](const MessagePtr& message) {
      Result& result = results_[message->header.stamp];
      take(result, message);
      on_change_(result);
    }));
  }

  StampCache<Result> results_;
  Callback on_change_;
  std::vector<ros::Subscriber> subscribers_;
};

}  // namespace corrsel
