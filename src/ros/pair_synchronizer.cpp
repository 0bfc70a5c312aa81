#include "corrsel/ros/pair_synchronizer.h"

#include <algorithm>
#include <utility>

namespace corrsel {

PairSynchronizer::PairSynchronizer(const ros::NodeHandle& nh, const ros::NodeHandle& pnh, Callback on_pair)
    : pnh_(pnh),
      on_pair_(std::move(on_pair)),
      queue_size_(static_cast<std::uint32_t>(std::max(1, pnh.param("subscriber_queue_size", 1)))),
      transport_(nh) {
  const auto queue = static_cast<std::uint32_t>(std::max(1, pnh.param("queue_size", 5)));
  const auto paired = [this](const sensor_msgs::ImageConstPtr& left,
                             const sensor_msgs::ImageConstPtr& right) {
    ++n_pairs_;
    on_pair_(left, right);
  };
  const auto callback = boost::bind<void>(paired, boost::placeholders::_1, boost::placeholders::_2);
  if (pnh.param("approximate_sync", false)) {
    approximate_ = std::make_unique<message_filters::Synchronizer<ApproximatePolicy>>(
        ApproximatePolicy(queue), left_, right_);
    const double interval = pnh.param("approximate_sync_max_interval", 0.0);
    if (interval > 0.0) approximate_->setMaxIntervalDuration(ros::Duration(interval));
    approximate_->registerCallback(callback);
  } else {
    exact_ = std::make_unique<message_filters::Synchronizer<ExactPolicy>>(ExactPolicy(queue), left_, right_);
    exact_->registerCallback(callback);
  }
  left_.registerCallback([this](const sensor_msgs::ImageConstPtr&) { ++n_left_; });
  right_.registerCallback([this](const sensor_msgs::ImageConstPtr&) { ++n_right_; });
}

void PairSynchronizer::subscribe() {
  if (subscribed_) return;
  const image_transport::TransportHints hints("raw", ros::TransportHints(), pnh_);
  left_.subscribe(transport_, "left/image", queue_size_, hints);
  right_.subscribe(transport_, "right/image", queue_size_, hints);
  subscribed_ = true;
}

void PairSynchronizer::unsubscribe() {
  if (!subscribed_) return;
  left_.unsubscribe();
  right_.unsubscribe();
  subscribed_ = false;
}

std::string PairSynchronizer::misses() {
  const std::size_t left = n_left_.exchange(0), right = n_right_.exchange(0), pairs = n_pairs_.exchange(0);
  const std::size_t most = std::max(left, right);
  if (most < 3 || most < 3 * pairs) return "";
  return std::to_string(left) + " left images (" + leftTopic() + ") and " + std::to_string(right) +
         " right images (" + rightTopic() + "), but only " + std::to_string(pairs) +
         " pairs. Are both topics published? Do their stamps agree? If not exactly, set ~approximate_sync; "
         "if one "
         "arrives later than the other, enlarge ~queue_size.";
}

}  // namespace corrsel
