#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "ros/live/camera_input.h"
#include "ros/live/image_source.h"

namespace corrsel {

/// Brings `left/image` and `right/image` together by their stamps, with the newest masks (`left/mask`,
/// `right/mask`) and calibrations (`left/camera_info`, `right/camera_info`).
///
/// When the stamps of a camera go backwards (a bag that is played in a loop, a clock that was set), all
/// waiting images are dropped. message_filters would keep them as the newest ones, and pairs would never form
/// again (exact), or only after as many images as the queue holds (approximate).
///
/// Approximate pairs are handed over as soon as no nearer stamp can come. That is known from the periods of
/// the cameras, which are estimated from their stamps; message_filters alone waits for the next image.
class PairSynchronizer : public ImageSource {
 public:
  PairSynchronizer(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                   const FeatureMatcherParameters& parameters, Callback on_set);
  ~PairSynchronizer() override;

  void subscribe() override;
  void unsubscribe() override;
  std::vector<std::string> topics() const override { return {left_.topic(), right_.topic()}; }
  Inputs inputs() const override;
  Counts counts() const override;
  std::string complaint() override;

 private:
  using ImagePair = std::pair<sensor_msgs::ImageConstPtr, sensor_msgs::ImageConstPtr>;
  class Synchronizer;  // hides message_filters, which takes long to compile
  enum Side { kLeft, kRight };

  void receive(Side side, const sensor_msgs::ImageConstPtr& msg, bool backwards);
  void makeSynchronizer();
  std::string mismatch(std::size_t n_sets) const;

  Callback on_set_;
  std::uint32_t queue_size_;
  bool approximate_sync_;
  double max_interval_;               ///< s, 0 = no limit
  std::atomic<bool> restart_{false};  ///< before the next image
  std::atomic<std::size_t> n_sets_{0};
  std::mutex period_mutex_;          ///< one complaint() at a time
  std::size_t n_sets_before_ = 0;    ///< before the period
  std::vector<ImagePair> complete_;  ///< pairs that the image in hand has completed
  std::unique_ptr<Synchronizer> synchronizer_;
  CameraInput left_, right_;  // last: no callback comes once they are gone
};

}  // namespace corrsel
