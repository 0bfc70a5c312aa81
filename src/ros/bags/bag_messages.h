#pragma once

// What the readers of robots' bags share: messages by their stamps.

#include <ros/message_traits.h>
#include <ros/serialization.h>
#include <rosbag/message_instance.h>
#include <sensor_msgs/CameraInfo.h>
#include <std_msgs/Header.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "ros/bags/dataset_bag.h"

namespace corrsel {

/// The beginning of every message with a header; what comes after it stays unread.
struct HeaderOnly {
  std_msgs::Header header;
};

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

inline constexpr char kInfoType[] = "sensor_msgs/CameraInfo";
inline constexpr char kTruthType[] = "corrsel/GroundTruth";
inline constexpr double kLongestStampDifference = 10.0;  // s

/// Types of a bag's messages, by topic.
using Types = std::map<std::string, std::string>;

/// Throws std::invalid_argument for options out of range.
void checkOptions(const BagTopics& options);

/// The name under which the bag has a topic, which may be given with or without the leading slash; empty
/// where it has none.
std::string nameInBag(const Types& types, const std::string& topic);

/// The topic with what is true, the one named or the usual one; empty where there is none. Throws
/// core::DatasetError where a topic is named that is not there; a usual one of another type is noted.
std::string truthTopic(const Types& types, const std::string& named, const std::string& path,
                       std::vector<std::string>& notes);

/// "0.25 s"
std::string secondsText(std::int64_t nanoseconds);

/// "1 message", "2 messages"
std::string count(std::size_t n, const std::string& noun);

/// A message, where it is in the bag, and its stamp in ns.
struct Stamped {
  std::int64_t stamp;
  rosbag::MessageInstance message;
};

/// Messages that could not be read or had no stamp, by topic.
struct ScanProblems {
  std::map<std::string, std::size_t> unreadable, unstamped;
  void describe(std::vector<std::string>& notes) const;
};

/// Appends a message by the stamp of its header, or by the time of its recording where that has none. Throws
/// exceptions of rosbag and ros::serialization.
void addStamped(const rosbag::MessageInstance& message, std::vector<Stamped>& list, ScanProblems& problems);

/// Sorts by stamp; equal ones stay in the order of the bag.
void sortByStamp(std::vector<Stamped>& list);

/// What a bag says about the calibration of one camera.
struct Calibration {
  std::string topic;
  std::optional<sensor_msgs::CameraInfo> info;  ///< the first one
  bool changes = false;
  /// Throws std::invalid_argument for another version of the message.
  void add(const rosbag::MessageInstance& message);
  void describe(std::vector<std::string>& notes) const;
};

std::vector<std::int64_t> stampsOf(const std::vector<Stamped>& messages);

struct Partners {
  std::vector<std::optional<std::size_t>> of;  ///< per stamp of the first list: its partner in the second
  std::int64_t least_difference = std::numeric_limits<std::int64_t>::max();  ///< ns, whether paired or not
  std::size_t size() const;
};

/// Pairs stamps that are nearest to each other and at most `tolerance` apart. Both lists are sorted.
Partners partners(const std::vector<std::int64_t>& first, const std::vector<std::int64_t>& second,
                  std::int64_t tolerance);

/// {bag's name, "bag", stamp}
core::PairId idInBag(const std::string& path, std::int64_t stamp);

/// The truth in a message. Throws std::invalid_argument for another version of the message and what fromMsg()
/// throws.
core::GroundTruth readTruth(const rosbag::MessageInstance& message);

}  // namespace corrsel
