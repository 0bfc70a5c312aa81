#include "ros/bags/bag_messages.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "ros/bags/bag_file.h"

namespace corrsel {
namespace {

/// Number of the stamp nearest to `stamp`; the earlier one of two, the first one of equals. @pre not empty
std::size_t nearest(const std::vector<std::int64_t>& stamps, std::int64_t stamp) {
  const auto first = [&stamps](std::int64_t value) {
    return std::lower_bound(stamps.begin(), stamps.end(), value);
  };
  const auto next = first(stamp);
  if (next == stamps.begin()) return 0;
  const auto before = std::prev(next);
  const bool take_next = next != stamps.end() && *next - stamp < stamp - *before;
  return static_cast<std::size_t>((take_next ? next : first(*before)) - stamps.begin());
}

bool equalCalibration(const sensor_msgs::CameraInfo& a, const sensor_msgs::CameraInfo& b) {
  return a.width == b.width && a.height == b.height && a.distortion_model == b.distortion_model &&
         a.D == b.D && a.K == b.K && a.R == b.R && a.P == b.P && a.binning_x == b.binning_x &&
         a.binning_y == b.binning_y && a.roi == b.roi;
}

}  // namespace

void checkOptions(const BagTopics& options) {
  if (options.images != "auto" && options.images != "raw" && options.images != "rectified") {
    throw std::invalid_argument("images = '" + options.images + "' is none of raw, rectified, auto");
  }
  if (!(options.max_stamp_difference >= 0 && options.max_stamp_difference <= kLongestStampDifference)) {
    throw std::invalid_argument("max_stamp_difference = " + core::formatNumber(options.max_stamp_difference) +
                                " is outside [0, " + core::formatNumber(kLongestStampDifference) + "] s");
  }
}

std::string nameInBag(const Types& types, const std::string& topic) {
  if (types.count(topic) != 0) return topic;
  const std::string other = !topic.empty() && topic[0] == '/' ? topic.substr(1) : "/" + topic;
  return types.count(other) != 0 ? other : "";
}

std::string truthTopic(const Types& types, const std::string& named, const std::string& path,
                       std::vector<std::string>& notes) {
  const std::string wanted = named.empty() ? bag_topics::kGroundTruth : named;
  const std::string found = nameInBag(types, wanted);
  if (!found.empty() && types.at(found) == kTruthType) return found;
  if (!named.empty()) {
    throw core::DatasetError("bag " + path + " has no " + kTruthType + " on " + wanted + "; it has " +
                             describeTopics(types));
  }
  if (!found.empty()) {
    notes.push_back(found + " is " + types.at(found) + ", not " + kTruthType + ", and is not looked at");
  }
  return "";
}

std::string secondsText(std::int64_t nanoseconds) {
  return core::formatNumber(static_cast<double>(nanoseconds) / 1e9) + " s";
}

std::string count(std::size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

void ScanProblems::describe(std::vector<std::string>& notes) const {
  for (const auto& [topic, n] : unreadable) {
    notes.push_back(count(n, "message") + " on " + topic + " cannot be read and are left out");
  }
  for (const auto& [topic, n] : unstamped) {
    notes.push_back(count(n, "message") + " on " + topic +
                    " have no stamp in the header: the time of recording is used");
  }
}

void addStamped(const rosbag::MessageInstance& message, std::vector<Stamped>& list, ScanProblems& problems) {
  ros::Time stamp = message.instantiate<HeaderOnly>()->header.stamp;
  if (stamp.isZero()) {
    stamp = message.getTime();
    ++problems.unstamped[message.getTopic()];
  }
  list.push_back({static_cast<std::int64_t>(stamp.toNSec()), message});
}

void sortByStamp(std::vector<Stamped>& list) {
  // A rosbag::MessageInstance cannot be assigned: their order is sorted instead.
  std::vector<std::size_t> order(list.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&list](std::size_t a, std::size_t b) { return list[a].stamp < list[b].stamp; });
  std::vector<Stamped> sorted;
  sorted.reserve(list.size());
  for (const std::size_t i : order) sorted.push_back(list[i]);
  list.swap(sorted);
}

void Calibration::add(const rosbag::MessageInstance& message) {
  const auto read = message.instantiate<sensor_msgs::CameraInfo>();
  if (read == nullptr) throw std::invalid_argument("another version of the message type");
  if (!info) {
    info = *read;
  } else if (!equalCalibration(*info, *read)) {
    changes = true;
  }
}

void Calibration::describe(std::vector<std::string>& notes) const {
  if (changes) notes.push_back("camera_info on " + topic + " changes in the bag: its first message is used");
}

std::vector<std::int64_t> stampsOf(const std::vector<Stamped>& messages) {
  std::vector<std::int64_t> stamps;
  stamps.reserve(messages.size());
  for (const Stamped& message : messages) stamps.push_back(message.stamp);
  return stamps;
}

std::size_t Partners::size() const {
  return static_cast<std::size_t>(
      std::count_if(of.begin(), of.end(), [](const auto& partner) { return partner.has_value(); }));
}

Partners partners(const std::vector<std::int64_t>& first, const std::vector<std::int64_t>& second,
                  std::int64_t tolerance) {
  Partners result;
  result.of.resize(first.size());
  if (second.empty()) return result;
  for (std::size_t i = 0; i < first.size(); ++i) {
    const std::size_t j = nearest(second, first[i]);
    const std::int64_t difference = std::abs(second[j] - first[i]);
    result.least_difference = std::min(result.least_difference, difference);
    if (difference <= tolerance && nearest(first, second[j]) == i) result.of[i] = j;
  }
  return result;
}

core::PairId idInBag(const std::string& path, std::int64_t stamp) {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp));
  return {std::filesystem::path(path).stem().string(), "bag", stampText(time)};
}

core::GroundTruth readTruth(const rosbag::MessageInstance& message) {
  const auto truth = message.instantiate<GroundTruth>();
  if (truth == nullptr) {
    throw std::invalid_argument("has another version of " + std::string(kTruthType) + ", checksum " +
                                message.getMD5Sum());
  }
  return fromMsg(*truth);
}

}  // namespace corrsel
