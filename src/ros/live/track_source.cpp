#include "ros/live/track_source.h"

#include <utility>

namespace corrsel {

TrackSource::TrackSource(const ros::NodeHandle& nh, const TrackerParameters& parameters, Callback on_item)
    : nh_(nh),
      bridging_(parameters.max_gap > 0),
      queue_size_(static_cast<std::uint32_t>(parameters.subscriber_queue_size)),
      on_item_(std::move(on_item)) {
  correspondences_.topic = "correspondences";
  selection_.topic = "selection";
  features_.topic = "features";
}

template <class Message>
void TrackSource::open(Input& input, boost::shared_ptr<const Message> TrackItem::*member) {
  input.subscriber = nh_.subscribe<Message>(
      input.topic, queue_size_, [this, &input, member](const boost::shared_ptr<const Message>& message) {
        ++input.received;
        TrackItem& item = items_[message->header.stamp];
        item.*member = message;
        complete(item);
      });
}

void TrackSource::subscribe() {
  if (bridging_) open(features_, &TrackItem::features);
  open(correspondences_, &TrackItem::correspondences);
  open(selection_, &TrackItem::selection);
}

void TrackSource::unsubscribe() {
  for (Input* input : {&features_, &correspondences_, &selection_}) input->subscriber.shutdown();
  items_.clear();
}

std::vector<std::string> TrackSource::topics() const {
  std::vector<std::string> names;
  for (const auto& input : inputs()) names.push_back(nh_.resolveName(input.first));
  return names;
}

LiveSource::Inputs TrackSource::inputs() const {
  Inputs inputs = {{correspondences_.topic, correspondences_.received},
                   {selection_.topic, selection_.received}};
  if (bridging_) inputs.emplace_back(features_.topic, features_.received);
  return inputs;
}

void TrackSource::complete(TrackItem& item) {
  if (!item.correspondences || !item.selection) return;
  TrackItem whole;
  std::swap(whole, item);  // a second selection finds no matches
  if (const TrackItem* reference = items_.find(whole.correspondences->right_stamp)) {
    whole.reference_features = reference->features;
  }
  whole.waiting.restart();
  on_item_(std::move(whole));
}

}  // namespace corrsel
