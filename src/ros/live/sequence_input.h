#pragma once

#include <atomic>
#include <cstddef>
#include <string>
#include <vector>

#include "ros/live/camera_input.h"
#include "ros/live/image_source.h"

namespace corrsel {

/// Every image of `image` is a set, with the newest mask of `mask` and the newest calibration of
/// `camera_info`.
class SequenceInput : public ImageSource {
 public:
  SequenceInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                const FeatureMatcherParameters& parameters, Callback on_set);
  ~SequenceInput() override { unsubscribe(); }

  void subscribe() override { camera_.subscribe(); }
  void unsubscribe() override { camera_.unsubscribe(); }
  std::vector<std::string> topics() const override { return {camera_.topic()}; }
  Inputs inputs() const override { return {{"image", camera_.count()}}; }
  Counts counts() const override;
  std::string complaint() override;

 private:
  Callback on_set_;
  std::atomic<std::size_t> n_sets_{0};
  CameraInput camera_;
};

}  // namespace corrsel
