#pragma once

#include <ros/time.h>
#include <rosbag/bag.h>

#include <map>
#include <memory>
#include <string>

namespace corrsel {

/// Opens a bag for reading. Throws core::DatasetError saying what is wrong and how to mend it: missing file,
/// not a bag, no index, cut off or damaged.
std::unique_ptr<rosbag::Bag> openBag(const std::string& path);

/// What is said about a bag that rosbag gives up on with `what`.
std::string damagedBagText(const std::string& path, const std::string& what);

/// Types of a bag's messages, by topic.
std::map<std::string, std::string> topicTypes(const rosbag::Bag& bag);

/// "/a (type), /b (type)", or "none".
std::string describeTopics(const std::map<std::string, std::string>& types);

/// Seconds and nanoseconds, nine digits: "12.500000000".
std::string stampText(const ros::Time& stamp);

}  // namespace corrsel
