#include "corrsel/tracking/track_keeper.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "base/match_costs.h"

namespace corrsel::core {
namespace {

constexpr std::uint64_t kNoTrack = 0;  ///< of a feature that has none yet
const cv::Point2f kNotSeen(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::quiet_NaN());

/// The links in the order in which they are taken.
std::vector<FeatureLink> ranked(std::vector<FeatureLink> links) {
  const auto key = [](const FeatureLink& link) {
    const float cost = std::isnan(link.cost) ? std::numeric_limits<float>::infinity() : link.cost;
    return std::make_tuple(cost, link.newest, link.earlier);
  };
  std::sort(links.begin(), links.end(),
            [&key](const FeatureLink& a, const FeatureLink& b) { return key(a) < key(b); });
  return links;
}

const std::vector<std::uint32_t>& numbersOf(const Correspondences& matches, MatchSide side) {
  const auto& numbers = side == MatchSide::kLeft ? matches.left_index : matches.right_index;
  if (numbers.size() != matches.size()) {
    throw std::invalid_argument(
        "tracks: " + std::string(side == MatchSide::kLeft ? "left_index" : "right_index") + " has " +
        std::to_string(numbers.size()) + " elements for " + std::to_string(matches.size()) +
        " matches; tracks need the number of the feature of every match");
  }
  return numbers;
}

}  // namespace

TrackKeeper::TrackKeeper(std::size_t max_gap, TrackBridge bridge, std::size_t max_frames)
    : max_gap_(max_gap), max_frames_(max_frames), bridge_(std::move(bridge)) {
  if (max_frames < max_gap + 2) {
    throw std::invalid_argument("tracks: max_frames is " + std::to_string(max_frames) +
                                ", expected at least " + std::to_string(max_gap + 2) + " (max_gap + 2)");
  }
}

const TrackKeeper::Record* TrackKeeper::find(std::uint64_t id) const {
  const auto found =
      std::lower_bound(frames_.begin(), frames_.end(), id,
                       [](const Record& record, std::uint64_t value) { return record.id < value; });
  return found == frames_.end() || found->id != id ? nullptr : &*found;
}

bool TrackKeeper::knows(std::uint64_t id) const { return find(id) != nullptr; }

std::optional<std::uint64_t> TrackKeeper::newest() const {
  return frames_.empty() ? std::nullopt : std::make_optional(frames_.back().id);
}

void TrackKeeper::check(const Frame& frame, const Record* reference,
                        const std::vector<FeatureLink>& links) const {
  const std::string name = "tracks: frame " + std::to_string(frame.id);
  if (!frames_.empty() && frame.id <= frames_.back().id) {
    throw std::invalid_argument(name + " comes after frame " + std::to_string(frames_.back().id) +
                                "; add frames in the order of their ids, or call reset()");
  }
  if (frame.features != nullptr && frame.features->keypoints.size() != frame.points.size()) {
    throw std::invalid_argument(name + " has " + std::to_string(frame.points.size()) + " points and " +
                                std::to_string(frame.features->keypoints.size()) +
                                " features; give one point for each feature");
  }
  for (const FeatureLink& link : links) {
    if (link.newest < frame.points.size() && link.earlier < reference->tracks.size()) continue;
    throw std::invalid_argument(name + ": a link joins its feature " + std::to_string(link.newest) + " of " +
                                std::to_string(frame.points.size()) + " with feature " +
                                std::to_string(link.earlier) + " of " +
                                std::to_string(reference->tracks.size()) + " of frame " +
                                std::to_string(reference->id) + "; features are numbered from 0");
  }
}

void TrackKeeper::add(Frame frame) {
  check(frame, nullptr, {});
  counts_ = {};
  Record record{frame.id, std::vector<std::uint64_t>(frame.points.size(), kNoTrack),
                std::move(frame.features)};
  finish(std::move(record), frame.points, std::nullopt);
}

void TrackKeeper::add(Frame frame, std::uint64_t reference, const std::vector<FeatureLink>& links) {
  const Record* const earlier = find(reference);
  if (earlier == nullptr) {
    throw std::invalid_argument("tracks: frame " + std::to_string(frame.id) + " refers to frame " +
                                std::to_string(reference) + ", which is not known; add that one first");
  }
  check(frame, earlier, links);
  counts_ = {};
  Record record{frame.id, std::vector<std::uint64_t>(frame.points.size(), kNoTrack),
                std::move(frame.features)};
  const std::vector<FeatureLink> order = ranked(links);
  counts_.continued = join(order, *earlier, record, frame.points);
  counts_.cut = order.size() - counts_.continued;
  reference_ = reference;
  finish(std::move(record), frame.points, reference);
}

/// Continues the tracks of the earlier frame. @return number of links that were used
std::size_t TrackKeeper::join(const std::vector<FeatureLink>& links, const Record& earlier, Record& record,
                              const std::vector<cv::Point2f>& points) {
  std::size_t joined = 0;
  for (const FeatureLink& link : links) {
    const std::uint64_t track = earlier.tracks[link.earlier];
    if (record.tracks[link.newest] != kNoTrack || states_.at(track).last.frame == record.id) continue;
    see(track, record, link.newest, points[link.newest]);
    ++joined;
  }
  return joined;
}

/// Notes that the frame has the track.
void TrackKeeper::see(std::uint64_t track, Record& record, std::uint32_t feature, const cv::Point2f& point) {
  State& state = states_[track];
  const bool before = state.age > 0 && state.last.frame == frames_.back().id;
  state.previous = before ? state.last.point : kNotSeen;
  state.last = {record.id, feature, point};
  if (state.age == 0) state.first = state.last;
  ++state.age;
  ++state.frames;
  record.tracks[feature] = track;
}

GapTask TrackKeeper::taskOf(const Record& earlier, const Record& record) const {
  GapTask task{*record.features, *earlier.features, {}, {}, {}};
  for (std::uint32_t i = 0; i < record.tracks.size(); ++i) {
    if (record.tracks[i] == kNoTrack) task.free.push_back(i);
  }
  for (std::uint32_t i = 0; i < earlier.tracks.size(); ++i) {
    const TrackSight& last = states_.at(earlier.tracks[i]).last;
    if (last.frame == earlier.id) task.lost.push_back(i);
    if (last.frame == record.id) task.seen.push_back({last.feature, i});
  }
  return task;
}

void TrackKeeper::bridgeGaps(std::optional<std::uint64_t> reference, Record& record,
                             const std::vector<cv::Point2f>& points) {
  if (max_gap_ == 0 || !bridge_ || record.features == nullptr) return;
  const std::size_t count = std::min(frames_.size(), max_gap_ + 1);
  for (std::size_t back = 1; back <= count; ++back) {
    const Record& earlier = frames_[frames_.size() - back];
    if (earlier.features == nullptr || earlier.id == reference) continue;
    const GapTask task = taskOf(earlier, record);
    std::vector<FeatureLink> links = ranked(bridge_(task));
    const auto unwanted = [&](const FeatureLink& link) {
      return !std::binary_search(task.free.begin(), task.free.end(), link.newest) ||
             !std::binary_search(task.lost.begin(), task.lost.end(), link.earlier);
    };
    links.erase(std::remove_if(links.begin(), links.end(), unwanted), links.end());
    counts_.bridged += join(links, earlier, record, points);
  }
}

/// Asks the bridge, begins tracks, and forgets what is too old.
void TrackKeeper::finish(Record record, const std::vector<cv::Point2f>& points,
                         std::optional<std::uint64_t> reference) {
  std::exception_ptr failure;
  try {
    bridgeGaps(reference, record, points);
  } catch (...) {  // the frame is a frame without it, too
    failure = std::current_exception();
  }
  for (std::uint32_t i = 0; i < record.tracks.size(); ++i) {
    if (record.tracks[i] != kNoTrack) continue;
    see(next_id_++, record, i, points[i]);
    ++counts_.begun;
  }
  if (!frames_.empty()) {
    for (const std::uint64_t track : frames_.back().tracks) {
      counts_.lost += states_.at(track).last.frame != record.id ? 1 : 0;
    }
  }
  frames_.push_back(std::move(record));
  forget();
  if (failure) std::rethrow_exception(failure);
}

void TrackKeeper::forget() {
  // The frames that the bridge may be asked about by the next frame.
  const std::size_t bridged = max_gap_ == 0 ? 0 : max_gap_ + 1;
  if (frames_.size() > bridged) frames_[frames_.size() - bridged - 1].features.reset();
  while (frames_.size() > max_frames_) {
    // The reference stays, however old it is.
    const auto oldest = frames_.begin() + (frames_.front().id == reference_ ? 1 : 0);
    for (const std::uint64_t track : oldest->tracks) {
      const auto state = states_.find(track);
      if (--state->second.frames == 0) states_.erase(state);
    }
    frames_.erase(oldest);
  }
}

void TrackKeeper::locate(std::uint64_t frame, const std::vector<cv::Point2f>& points) {
  const Record* const record = find(frame);
  if (record == nullptr) return;
  for (std::size_t i = 0; i < std::min(points.size(), record->tracks.size()); ++i) {
    State& state = states_.at(record->tracks[i]);
    if (state.last.frame != frame || !std::isnan(state.last.point.x)) continue;
    state.last.point = points[i];
    if (state.first.frame == frame) state.first.point = points[i];
  }
}

std::vector<FeatureTrack> TrackKeeper::tracks() const {
  std::vector<FeatureTrack> result;
  if (frames_.empty()) return result;
  result.reserve(frames_.back().tracks.size());
  for (const std::uint64_t track : frames_.back().tracks) {
    const State& state = states_.at(track);
    result.push_back({track, state.age, state.first, state.last.point, state.previous});
  }
  return result;
}

void TrackKeeper::reset() {
  frames_.clear();
  states_.clear();
  reference_.reset();
  counts_ = {};
}

std::vector<FeatureLink> selectedLinks(const Correspondences& matches,
                                       const std::vector<std::uint8_t>& mask) {
  const auto& left = numbersOf(matches, MatchSide::kLeft);
  const auto& right = numbersOf(matches, MatchSide::kRight);
  if (mask.size() != matches.size()) {
    throw std::invalid_argument("tracks: the mask has " + std::to_string(mask.size()) + " elements for " +
                                std::to_string(matches.size()) + " matches; give the mask of these matches");
  }
  const MatchCosts costs(matches);
  std::vector<FeatureLink> links;
  for (const std::uint32_t row : selectedRows(mask)) {
    links.push_back({left[row], right[row], costs.known() ? costs.nearest(row) : 0.0F});
  }
  return links;
}

std::vector<cv::Point2f> matchedPoints(const Correspondences& matches, MatchSide side,
                                       std::size_t n_features) {
  constexpr std::size_t kMaxFeatures = 1000000;
  if (n_features > kMaxFeatures) {
    throw std::invalid_argument("tracks: an image has " + std::to_string(n_features) +
                                " features, expected at most " + std::to_string(kMaxFeatures));
  }
  const std::vector<std::uint32_t>& numbers = numbersOf(matches, side);
  const bool left = side == MatchSide::kLeft;
  std::vector<cv::Point2f> points(n_features, kNotSeen);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] >= n_features) {
      throw std::invalid_argument("tracks: match " + std::to_string(i) + " has the " +
                                  (left ? "left" : "right") + " feature " + std::to_string(numbers[i]) +
                                  " of an image with " + std::to_string(n_features) +
                                  " features; state how many features each image has");
    }
    points[numbers[i]] = {left ? matches.left_x[i] : matches.right_x[i],
                          left ? matches.left_y[i] : matches.right_y[i]};
  }
  return points;
}

}  // namespace corrsel::core
