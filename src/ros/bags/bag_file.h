#pragma once

#include <ros/time.h>
#include <rosbag/bag.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/image_pair.h"

namespace corrsel {

/// Types of a bag's messages, by topic.
using TopicTypes = std::map<std::string, std::string>;

/// A bag that is open for reading, with what its index holds: topics, types and numbers of messages. No
/// message is read for these.
class BagFile {
 public:
  /// Throws core::DatasetError that names the cause and the remedy if the file is missing, is not a bag, has
  /// no index, is cut off or is damaged.
  explicit BagFile(const std::string& path);

  const std::string& path() const { return path_; }
  const rosbag::Bag& bag() const { return *bag_; }
  const TopicTypes& types() const { return types_; }

  bool has(const std::string& topic, const std::string& type) const;

  /// The name under which the bag has a topic that is given with or without the leading slash; empty where it
  /// has none.
  std::string find(const std::string& topic) const;

  /// The same for a topic whose messages have this type.
  std::string find(const std::string& topic, const std::string& type) const;

  std::vector<std::string> topicsOfType(const std::string& type) const;

  /// Number of messages on a topic. O(chunks).
  std::size_t count(const std::string& topic) const;

  /// "/a (type), /b (type)", or "none".
  std::string describeTopics() const;

  /// {name of the bag, "bag", stamp}. @param stamp  ns
  core::PairId idAt(std::int64_t stamp) const;

  /// Throws core::DatasetError: the bag is cut off or damaged; the text contains the message of rosbag.
  [[noreturn]] void failDamaged(const rosbag::BagException& error) const;

 private:
  std::string path_;
  std::unique_ptr<rosbag::Bag> bag_;
  TopicTypes types_;
};

/// Seconds and nanoseconds, nine digits: "12.500000000".
std::string stampText(const ros::Time& stamp);

}  // namespace corrsel
