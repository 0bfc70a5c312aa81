#include "ros/live/live_tracker.h"

#include <boost/make_shared.hpp>
#include <cmath>
#include <exception>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/features.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/tracking/gap_bridge.h"

namespace corrsel {
namespace {

/// A frame whose features are known by their messages, or else by the matches.
core::TrackKeeper::Frame frameOf(const ros::Time& stamp, const FeaturesConstPtr& features,
                                 const core::Correspondences& matches, core::MatchSide side,
                                 std::size_t n_features) {
  core::TrackKeeper::Frame frame;
  frame.id = stamp.toNSec();
  if (!features) {
    frame.points = core::matchedPoints(matches, side, n_features);
    return frame;
  }
  frame.features = std::make_shared<core::Features>(fromMsg(*features));
  if (frame.features->keypoints.size() != n_features) {
    throw std::invalid_argument("features has " + std::to_string(frame.features->keypoints.size()) +
                                " keypoints, but the matches with its stamp are of " +
                                std::to_string(n_features) + "; both must be about the same features");
  }
  for (const cv::KeyPoint& keypoint : frame.features->keypoints) frame.points.push_back(keypoint.pt);
  return frame;
}

std::string kindOf(const Correspondences& message) {
  return message.features + " " + std::to_string(message.left_width) + "x" +
         std::to_string(message.left_height);
}

/// The links of a selection; none if it is not to be relied on.
std::vector<core::FeatureLink> linksOf(const core::Correspondences& matches,
                                       const core::Selection& selection) {
  if (selection.status == core::Status::kUncertain) return {};
  return core::selectedLinks(matches, selection.mask);
}

}  // namespace

LiveTracker::LiveTracker(const TrackerParameters& parameters)
    : max_gap_(parameters.max_gap),
      threads_(parameters.threads),
      min_age_(accepted_.min_age),
      selector_(core::createSelector(accepted_.selector)),
      keeper_(static_cast<std::size_t>(parameters.max_gap)) {}

std::string LiveTracker::configure(TrackerConfig& config) {
  try {
    std::shared_ptr<const core::Selector> selector = core::createSelector(config.selector);
    const std::lock_guard<std::mutex> lock(mutex_);
    selector_ = std::move(selector);
  } catch (const std::exception& error) {
    config = accepted_;
    return "not changed: " + std::string(error.what()) + "; the selector '" + accepted_.selector +
           "' stays in force";
  }
  accepted_ = config;
  min_age_ = config.min_age;
  return "";
}

LiveTracker::Result LiveTracker::add(const TrackItem& item) {
  const core::Stopwatch watch;
  const Correspondences& of = *item.correspondences;
  const core::Correspondences matches = fromMsg(of);
  const core::Selection selection = fromMsg(*item.selection);
  const std::vector<core::FeatureLink> links = linksOf(matches, selection);
  core::TrackKeeper::Frame frame =
      frameOf(of.header.stamp, item.features, matches, core::MatchSide::kLeft, of.n_left_features);
  const std::string kind = kindOf(of);
  if (kind != kind_ || frame.id < keeper_.newest().value_or(0)) keeper_.reset();
  kind_ = kind;
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    keeper_.setBridge(core::GapBridge(selector_, threads_));
  }
  const std::uint64_t reference = of.right_stamp.toNSec();
  Result result;
  if (!keeper_.knows(reference) && reference > keeper_.newest().value_or(0)) {
    addReference(item, matches);
    write(reference, result.warning);
  }
  const std::uint64_t id = frame.id, previous = keeper_.newest().value_or(0);
  if (keeper_.knows(reference)) {
    keeper_.locate(reference, core::matchedPoints(matches, core::MatchSide::kRight, of.n_right_features));
    keeper_.add(std::move(frame), reference, links);
  } else {  // forgotten
    keeper_.add(std::move(frame));
  }
  write(id, result.warning);
  if (max_gap_ > 0 && !item.features && result.warning.empty()) {
    result.warning =
        "no features with the stamp of a selection have arrived, so that gaps are not bridged; "
        "publish them, or set ~max_gap to 0";
  }
  result.tracks = message(of);
  result.tracks->previous_stamp.fromNSec(previous);
  result.tracks->seconds = watch.seconds();
  return result;
}

/// Adds the earlier frame of the first matches, or one whose selection was dropped.
void LiveTracker::addReference(const TrackItem& item, const core::Correspondences& matches) {
  const Correspondences& of = *item.correspondences;
  keeper_.add(frameOf(of.right_stamp, item.reference_features, matches, core::MatchSide::kRight,
                      of.n_right_features));
}

void LiveTracker::write(std::uint64_t frame, std::string& warning) {
  if (!file_) return;
  try {
    file_->add(frame, keeper_.tracks());
  } catch (const std::runtime_error& error) {
    warning = std::string(error.what()) + "; it ends here";
    file_.reset();
  }
}

boost::shared_ptr<Tracks> LiveTracker::message(const Correspondences& of) const {
  auto message = boost::make_shared<Tracks>();
  message->header = of.header;
  message->features = of.features;
  message->width = of.left_width;
  message->height = of.left_height;
  const std::vector<core::FeatureTrack> tracks = keeper_.tracks();
  const auto min_age = static_cast<std::uint32_t>(min_age_);
  for (std::uint32_t i = 0; i < tracks.size(); ++i) {
    const core::FeatureTrack& track = tracks[i];
    if (track.age < min_age || std::isnan(track.point.x)) continue;
    message->id.push_back(track.id);
    message->age.push_back(track.age);
    message->x.push_back(track.point.x);
    message->y.push_back(track.point.y);
    message->previous_x.push_back(track.previous.x);
    message->previous_y.push_back(track.previous.y);
    message->feature_index.push_back(i);
  }
  const core::TrackKeeper::Counts& counts = keeper_.counts();
  message->n_continued = static_cast<std::uint32_t>(counts.continued);
  message->n_bridged = static_cast<std::uint32_t>(counts.bridged);
  message->n_begun = static_cast<std::uint32_t>(counts.begun);
  message->n_cut = static_cast<std::uint32_t>(counts.cut);
  message->n_lost = static_cast<std::uint32_t>(counts.lost);
  return message;
}

}  // namespace corrsel
