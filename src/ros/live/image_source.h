#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/Image.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "base/stopwatch.h"
#include "ros/live/camera_info_input.h"
#include "ros/live/live_source.h"
#include "ros/live/nodelet_parameters.h"

namespace corrsel {

/// Images that are matched with each other, as they arrived.
struct ImageSet {
  sensor_msgs::ImageConstPtr left;        ///< in sequence mode: the newest image
  sensor_msgs::ImageConstPtr right;       ///< null in sequence mode
  sensor_msgs::ImageConstPtr left_mask;   ///< newest mask of the camera, null = none
  sensor_msgs::ImageConstPtr right_mask;  ///< newest mask of the camera, null = none
  CalibrationPtr left_calibration;        ///< null = none that fits the image
  CalibrationPtr right_calibration;       ///< null = none that fits the image
  core::Stopwatch waiting;                ///< started when the set was complete
};

/// Where image sets come from.
///
/// The callback and everything that arrives are called on the queue of the given node handle, which must call
/// one callback at a time. Stamps may be anything: stamps that are zero, repeat, go backwards or jump are
/// passed on and reported by complaint().
class ImageSource : public LiveSource {
 public:
  using Callback = std::function<void(ImageSet)>;

  struct Counts {
    std::size_t left = 0;   ///< images of the left camera; in sequence mode: all images
    std::size_t right = 0;  ///< images of the right camera
    std::size_t sets = 0;   ///< sets handed over
  };

  /// Counts since construction. Any thread.
  virtual Counts counts() const = 0;

  /// Why no sets have been formed since the previous call, or what is wrong with the stamps; empty = nothing.
  /// The text contains counts, topics, the measured difference of the stamps and the remedies. A silent input
  /// is reported once, until it is heard again. Any thread.
  std::string complaint() override = 0;
};

/// Opens a PairSynchronizer or a SequenceInput, as the parameters ask for. It does not subscribe yet.
/// @param pnh  private handle, below which a transport's plug-in looks for its parameters
std::unique_ptr<ImageSource> openImageSource(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                                             const FeatureMatcherParameters& parameters,
                                             ImageSource::Callback on_set);

}  // namespace corrsel
