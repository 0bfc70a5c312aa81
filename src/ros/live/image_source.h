#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/stopwatch.h"

namespace corrsel {

/// Images to be matched, as they came in.
struct ImageSet {
  sensor_msgs::ImageConstPtr left;        ///< in sequence mode: the newest image
  sensor_msgs::ImageConstPtr right;       ///< null in sequence mode
  sensor_msgs::ImageConstPtr left_mask;   ///< newest mask of the camera, null = none
  sensor_msgs::ImageConstPtr right_mask;  ///< newest mask of the camera, null = none
  core::Stopwatch waiting;                ///< started when the set was complete
};

/// Where image sets come from.
///
/// The callback and everything that arrives are called on the queue of the node handle given, which must call
/// one at a time. Stamps may be anything: zero, equal, going backwards or wild ones are passed on and
/// complained about.
class ImageSource {
 public:
  using Callback = std::function<void(ImageSet)>;

  struct Counts {
    std::size_t left = 0;   ///< images of the left camera; in sequence mode: all images
    std::size_t right = 0;  ///< images of the right camera
    std::size_t sets = 0;   ///< sets handed over
  };

  virtual ~ImageSource() = default;

  /// Idempotent, as unsubscribe() is. Not to be called side by side.
  virtual void subscribe() = 0;

  /// Waits for a callback that is running on another thread, so the caller must not hold a lock that the
  /// callback takes; afterwards there are no more. May be called from the callback itself.
  virtual void unsubscribe() = 0;

  /// Resolved names of the images' topics, left first. Any thread.
  virtual std::vector<std::string> topics() const = 0;

  /// Since construction. Any thread.
  virtual Counts counts() const = 0;

  /// Why sets do not form (since the call before), or what is wrong with the stamps; empty = nothing. With
  /// counts, topics, measured gap and cures. That an input is silent is said once, until it speaks again.
  /// Any thread.
  virtual std::string complaint() = 0;
};

/// Private parameter `mode`: "pair" (default) gives a PairSynchronizer, "sequence" a SequenceInput.
/// Subscribes to nothing yet. Throws std::invalid_argument for another value, naming both.
std::unique_ptr<ImageSource> openImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                                             ImageSource::Callback on_set);

}  // namespace corrsel
