#include "ros/bags/bag_scan.h"

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <rosbag/view.h>
#include <std_msgs/Header.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/ros/conversions.h"

namespace corrsel {
namespace {

/// The beginning of every message with a header. What comes after it stays unread.
struct HeaderOnly {
  std_msgs::Header header;
};

}  // namespace
}  // namespace corrsel

namespace ros::message_traits {
template <>
struct MD5Sum<corrsel::HeaderOnly> {
  static const char* value() { return "*"; }  // any type of message
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<corrsel::HeaderOnly> {
  template <typename Stream>
  static void read(Stream& stream, corrsel::HeaderOnly& message) {
    stream.next(message.header);
  }
};
}  // namespace ros::serialization

namespace corrsel {
namespace {

/// Index of the stamp nearest to `stamp`: the earlier one of two, the first one of equals. @pre not empty
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

void sortByStamp(std::vector<Stamped>& list) {
  // A rosbag::MessageInstance cannot be assigned, so the order is sorted instead.
  std::vector<std::size_t> order(list.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::stable_sort(order.begin(), order.end(),
                   [&list](std::size_t a, std::size_t b) { return list[a].stamp < list[b].stamp; });
  std::vector<Stamped> sorted;
  sorted.reserve(list.size());
  for (const std::size_t i : order) sorted.push_back(list[i]);
  list.swap(sorted);
}

void addInfo(const rosbag::MessageInstance& message, Calibration& calibration) {
  const auto read = message.instantiate<sensor_msgs::CameraInfo>();
  if (read == nullptr) throw std::invalid_argument("another version of the message type");
  if (!calibration.info) {
    calibration.info = *read;
  } else if (!equalCalibration(*calibration.info, *read)) {
    calibration.changes = true;
  }
}

}  // namespace

BagScan::BagScan(const BagFile& file, const std::vector<Topic>& stamped,
                 const std::vector<std::string>& infos) {
  std::vector<std::string> wanted = infos;
  std::map<std::string, std::string> checksums;
  for (const std::string& topic : infos) calibrations_[topic].topic = topic;
  for (const Topic& topic : stamped) {
    wanted.push_back(topic.name);
    checksums[topic.name] = topic.checksum;
    messages_[topic.name];
  }
  try {
    rosbag::View view(file.bag(), rosbag::TopicQuery(wanted));
    for (const rosbag::MessageInstance& message : view) {
      try {
        add(message, checksums);
      } catch (const std::exception&) {  // a damaged chunk, or another version of the message
        ++unreadable_[message.getTopic()];
      }
    }
  } catch (const rosbag::BagException& error) {
    file.failDamaged(error);
  }
  for (auto& entry : messages_) sortByStamp(entry.second);
}

void BagScan::add(const rosbag::MessageInstance& message,
                  const std::map<std::string, std::string>& checksums) {
  const std::string& topic = message.getTopic();
  const auto info = calibrations_.find(topic);
  if (info != calibrations_.end()) addInfo(message, info->second);
  const auto list = messages_.find(topic);
  if (list == messages_.end()) return;
  const std::string& checksum = checksums.at(topic);
  if (checksum != "*" && checksum != message.getMD5Sum()) {
    throw std::invalid_argument("another version of the message type");
  }
  ros::Time stamp = message.instantiate<HeaderOnly>()->header.stamp;
  if (stamp.isZero()) {
    stamp = message.getTime();
    ++unstamped_[topic];
  }
  list->second.push_back({static_cast<std::int64_t>(stamp.toNSec()), message});
}

std::vector<Stamped> BagScan::take(const std::string& topic) {
  std::vector<Stamped> result;
  const auto found = messages_.find(topic);
  if (found != messages_.end()) result.swap(found->second);
  return result;
}

const Calibration& BagScan::calibration(const std::string& topic) const { return calibrations_.at(topic); }

std::size_t BagScan::unreadable(const std::string& topic) const {
  const auto found = unreadable_.find(topic);
  return found == unreadable_.end() ? 0 : found->second;
}

void BagScan::describe(std::vector<std::string>& notes) const {
  for (const auto& [topic, n] : unreadable_) {
    notes.push_back(count(n, "message") + " on " + topic + " cannot be read and are left out");
  }
  for (const auto& [topic, n] : unstamped_) {
    notes.push_back(count(n, "message") + " on " + topic +
                    " have no stamp in the header: the time of recording is used");
  }
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
    result.min_difference = std::min(result.min_difference, difference);
    if (difference <= tolerance && nearest(first, second[j]) == i) result.of[i] = j;
  }
  return result;
}

std::int64_t tolerance(const BagTopics& options) {
  return static_cast<std::int64_t>(std::llround(options.max_stamp_difference * 1e9));
}

std::string truthTopic(const BagFile& file, const std::string& named, std::vector<std::string>& notes) {
  const std::string wanted = named.empty() ? bag_topics::kGroundTruth : named;
  const std::string found = file.find(wanted);
  if (file.has(found, kTruthType)) return found;
  if (!named.empty()) {
    throw core::DatasetError("bag " + file.path() + " has no " + kTruthType + " on " + wanted + "; it has " +
                             file.describeTopics());
  }
  if (!found.empty()) {
    notes.push_back(found + " is " + file.types().at(found) + ", not " + kTruthType + ", and is not used");
  }
  return "";
}

std::string namedInfoTopic(const BagFile& file, const std::string& named, const std::string& side) {
  const std::string found = file.find(named, kInfoType);
  if (!found.empty()) return found;
  throw core::DatasetError("bag " + file.path() + " has no " + kInfoType + " for " + side + " on " + named +
                           "; it has " + file.describeTopics());
}

void describeChanges(const Calibration& calibration, std::vector<std::string>& notes) {
  if (!calibration.changes) return;
  notes.push_back("camera_info on " + calibration.topic + " changes in the bag: its first message is used");
}

core::GroundTruth readTruth(const rosbag::MessageInstance& message) {
  const auto truth = message.instantiate<GroundTruth>();
  if (truth == nullptr) {
    throw std::invalid_argument("has another version of " + std::string(kTruthType) + ", checksum " +
                                message.getMD5Sum());
  }
  return fromMsg(*truth);
}

std::string secondsText(std::int64_t nanoseconds) {
  return core::formatNumber(static_cast<double>(nanoseconds) / 1e9) + " s";
}

std::string count(std::size_t n, const std::string& noun) {
  return std::to_string(n) + " " + noun + (n == 1 ? "" : "s");
}

std::string calibrationText(std::size_t evaluated, std::size_t pairs, const Calibration& left,
                            const Calibration& right) {
  if (evaluated == 0) return "";
  return std::to_string(evaluated) + " of " + count(pairs, "pair") + (evaluated == 1 ? " is" : " are") +
         " evaluated with camera_info on " + left.topic + " and " + right.topic;
}

}  // namespace corrsel
