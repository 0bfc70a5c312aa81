#pragma once

#include <ros/node_handle.h>
#include <ros/subscriber.h>
#include <sensor_msgs/Image.h>

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "corrsel/Correspondences.h"
#include "corrsel/matching/match_mask.h"
#include "ros/live/live_source.h"
#include "ros/live/mask_gate.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/periodic.h"

namespace corrsel {

/// A message with matches, and since when it has been here.
struct TimedMatches {
  CorrespondencesConstPtr message;
  core::Stopwatch waiting;
};

/// `correspondences` together with the masks of `left/mask` and `right/mask`, or of `mask` in a sequence: see
/// MaskGate. A topic that nobody publishes is not waited for. Time is that of the steady clock.
class MaskedSource : public LiveSource {
 public:
  using Gate = MaskGate<TimedMatches>;
  using Callback = std::function<void(TimedMatches, PairMasks)>;

  /// Does not subscribe yet.
  /// @param on_matches  takes over the matches, in their order; called on the queue of `nh` or on a thread of
  ///                    this object, one call at a time
  /// @param on_problem  told what is wrong with a mask, which is then ignored; called on the queue of `nh`
  MaskedSource(const ros::NodeHandle& nh, const SelectorParameters& parameters, Callback on_matches,
               std::function<void(const std::string&)> on_problem);
  ~MaskedSource() override { unsubscribe(); }

  void subscribe() override;
  void unsubscribe() override;
  std::vector<std::string> topics() const override { return matches_.topics(); }
  Inputs inputs() const override { return matches_.inputs(); }

  /// That masks come, but none of them belongs to a pair.
  std::string complaint() override;

  /// Any thread.
  Gate::Counts counts() const;

 private:
  struct MaskTopic {
    Gate::Side side;
    std::string name;
    ros::Subscriber subscriber;  ///< written under the mutex
  };

  void receiveMatches(const CorrespondencesConstPtr& message);
  void receiveMask(const MaskTopic& topic, const sensor_msgs::ImageConstPtr& message);
  void expectPublished();
  void handOver(Gate::Pairs pairs);

  ros::NodeHandle nh_;
  const std::uint32_t queue_size_;
  const double poll_period_;  ///< s
  const core::MaskOptions mask_options_;
  const Callback on_matches_;
  const std::function<void(const std::string&)> on_problem_;
  const core::Stopwatch clock_;
  mutable std::mutex mutex_;  ///< guards the gate, and the order in which pairs are handed over
  Gate gate_;
  Gate::Counts complained_;  ///< the counts at the last complaint()
  std::vector<MaskTopic> masks_;
  MessageSource<Correspondences> matches_;
  std::unique_ptr<Periodic> timer_;
};

}  // namespace corrsel
