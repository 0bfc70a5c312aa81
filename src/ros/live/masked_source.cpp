#include "ros/live/masked_source.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "base/text.h"
#include "ros/live/image_mask.h"

namespace corrsel {
namespace {

constexpr double kShortestPoll = 1e-3, kLongestPoll = 0.02;  // s

MaskGateOptions gateOptions(const SelectorParameters& parameters) {
  MaskGateOptions options;
  options.sequence = parameters.mode == FeatureMode::kSequence;
  options.timeout = parameters.mask_timeout;
  options.max_age = parameters.mask_max_age;
  return options;
}

}  // namespace

MaskedSource::MaskedSource(const ros::NodeHandle& nh, const SelectorParameters& parameters,
                           Callback on_matches, std::function<void(const std::string&)> on_problem)
    : nh_(nh),
      queue_size_(static_cast<std::uint32_t>(parameters.subscriber_queue_size)),
      poll_period_(std::clamp(0.1 * parameters.mask_timeout, kShortestPoll, kLongestPoll)),
      mask_options_{parameters.maskClassList(), parameters.mask_dilation},
      on_matches_(std::move(on_matches)),
      on_problem_(std::move(on_problem)),
      gate_(gateOptions(parameters)),
      matches_(nh, "correspondences", queue_size_,
               [this](const CorrespondencesConstPtr& message) { receiveMatches(message); }) {
  if (parameters.mode == FeatureMode::kSequence) {
    masks_.push_back({Gate::kLeft, "mask", {}});
  } else {
    masks_.push_back({Gate::kLeft, "left/mask", {}});
    masks_.push_back({Gate::kRight, "right/mask", {}});
  }
}

void MaskedSource::subscribe() {
  if (timer_) return;
  for (MaskTopic& topic : masks_) {
    const std::lock_guard<std::mutex> lock(mutex_);
    topic.subscriber = nh_.subscribe<sensor_msgs::Image>(
        topic.name, queue_size_,
        [this, &topic](const sensor_msgs::ImageConstPtr& message) { receiveMask(topic, message); });
  }
  matches_.subscribe();
  timer_ = std::make_unique<Periodic>(poll_period_, [this] {
    const std::lock_guard<std::mutex> lock(mutex_);
    expectPublished();
    handOver(gate_.poll(clock_.seconds()));
  });
}

void MaskedSource::unsubscribe() {
  timer_.reset();
  matches_.unsubscribe();
  for (MaskTopic& topic : masks_) {
    ros::Subscriber subscriber;
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      std::swap(subscriber, topic.subscriber);
    }
    subscriber.shutdown();  // waits for a callback, which takes the mutex
  }
  const std::lock_guard<std::mutex> lock(mutex_);
  gate_.clear();
}

void MaskedSource::receiveMatches(const CorrespondencesConstPtr& message) {
  const MaskTrack::Stamp left = static_cast<MaskTrack::Stamp>(message->header.stamp.toNSec());
  const MaskTrack::Stamp right = static_cast<MaskTrack::Stamp>(message->right_stamp.toNSec());
  const std::lock_guard<std::mutex> lock(mutex_);
  expectPublished();
  handOver(gate_.addPair({message, core::Stopwatch()}, left, right, clock_.seconds()));
}

void MaskedSource::receiveMask(const MaskTopic& topic, const sensor_msgs::ImageConstPtr& message) {
  cv::Mat mask;
  try {
    mask = toMask(message, mask_options_);
  } catch (const std::exception& error) {
    on_problem_(nh_.resolveName(topic.name) + ": ignored: " + error.what());
    return;
  }
  const MaskTrack::Stamp stamp = static_cast<MaskTrack::Stamp>(message->header.stamp.toNSec());
  const std::lock_guard<std::mutex> lock(mutex_);
  handOver(gate_.addMask(topic.side, stamp, std::move(mask), clock_.seconds()));
}

/// @pre the mutex is held
void MaskedSource::expectPublished() {
  for (const MaskTopic& topic : masks_) gate_.expect(topic.side, topic.subscriber.getNumPublishers() > 0);
}

/// @pre the mutex is held
void MaskedSource::handOver(Gate::Pairs pairs) {
  for (Gate::Pair& pair : pairs) on_matches_(std::move(pair.item), std::move(pair.masks));
}

MaskedSource::Gate::Counts MaskedSource::counts() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return gate_.counts();
}

std::string MaskedSource::complaint() {
  constexpr std::size_t kFew = 3;
  const Gate::Counts now = counts();
  const std::size_t masks = now.masks - complained_.masks,
                    pairs = now.pairs_unmasked - complained_.pairs_unmasked;
  const bool fits = now.pairs_masked > complained_.pairs_masked;
  complained_ = now;
  if (fits || masks < kFew || pairs < kFew) return "";
  std::vector<std::string> topics;
  for (const MaskTopic& topic : masks_) topics.push_back(nh_.resolveName(topic.name));
  return std::to_string(masks) + " masks (" + core::joinList(topics, ", ") + ") and " +
         std::to_string(pairs) +
         " pairs, but no pair had all its masks. Remedies: masks with the stamps of their images; a larger "
         "~mask_timeout if masks come later than that; ~mask_max_age if their stamps differ from those of "
         "the "
         "images";
}

}  // namespace corrsel
