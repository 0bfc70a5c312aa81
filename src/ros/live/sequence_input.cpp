#include "ros/live/sequence_input.h"

#include <utility>

namespace corrsel {

SequenceInput::SequenceInput(const ros::NodeHandle& nh, const ros::NodeHandle& pnh,
                             const FeatureMatcherParameters& parameters, Callback on_set)
    : on_set_(std::move(on_set)),
      camera_(nh, pnh, parameters, "", [this](const sensor_msgs::ImageConstPtr& msg, bool) {
        ImageSet set;
        set.left = msg;
        set.left_mask = camera_.mask();
        set.left_calibration = camera_.calibration(*msg);
        ++n_sets_;
        on_set_(std::move(set));
      }) {}

ImageSource::Counts SequenceInput::counts() const {
  Counts counts;
  counts.left = camera_.count();
  counts.sets = n_sets_;
  return counts;
}

std::string SequenceInput::complaint() {
  const std::string text = camera_.complaint();
  camera_.newPeriod();
  return text;
}

}  // namespace corrsel
