#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>

#include <atomic>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "corrsel/Correspondences.h"
#include "corrsel/Features.h"
#include "corrsel/Selection.h"
#include "ros/live/live_source.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/stamp_cache.h"

namespace corrsel {

/// What is known about a frame of a sequence.
struct TrackItem {
  CorrespondencesConstPtr correspondences;
  SelectionConstPtr selection;
  FeaturesConstPtr features;            ///< of the frame; null if they have not come
  FeaturesConstPtr reference_features;  ///< of the earlier frame if it had no item of its own; else null
  core::Stopwatch waiting;              ///< started when the item was complete
};

/// Brings `correspondences`, `selection` and, if gaps are bridged, `features` together by their stamps. An
/// item is complete when a selection and its matches are there, whether the features have come or not. The
/// first selection counts if there are several selectors.
///
/// The callback is called on the queue of the node handle, which must call one callback at a time.
class TrackSource : public LiveSource {
 public:
  using Callback = std::function<void(TrackItem)>;

  /// Does not subscribe yet.
  TrackSource(const ros::NodeHandle& nh, const TrackerParameters& parameters, Callback on_item);

  void subscribe() override;
  void unsubscribe() override;
  std::vector<std::string> topics() const override;
  Inputs inputs() const override;

 private:
  /// What one topic brings.
  struct Input {
    std::string topic;
    ros::Subscriber subscriber;
    std::atomic<std::size_t> received{0};
  };

  template <class Message>
  void open(Input& input, boost::shared_ptr<const Message> TrackItem::*member);
  void complete(TrackItem& item);

  static constexpr std::size_t kCapacity = 30;  ///< stamps that are remembered

  ros::NodeHandle nh_;
  const bool bridging_;
  const std::uint32_t queue_size_;
  const Callback on_item_;
  Input correspondences_, selection_, features_;
  StampCache<TrackItem> items_{kCapacity};
};

}  // namespace corrsel
