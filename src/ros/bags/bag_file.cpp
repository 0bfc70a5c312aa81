#include "ros/bags/bag_file.h"

#include <rosbag/view.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "base/text.h"
#include "corrsel/datasets/reader.h"

namespace corrsel {
namespace {

bool looksLikeBag(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic(8, '\0');
  file.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  return file && magic == "#ROSBAG ";
}

}  // namespace

std::string damagedBagText(const std::string& path, const std::string& what) {
  return "bag " + path + " is cut off or damaged (" + what + "); run: rosbag reindex " + path;
}

std::unique_ptr<rosbag::Bag> openBag(const std::string& path) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {
    throw core::DatasetError("bag " + path + " does not exist or is not a file");
  }
  if (!looksLikeBag(path)) {
    throw core::DatasetError(path + " is not a bag: it does not begin with '#ROSBAG'");
  }
  try {
    return std::make_unique<rosbag::Bag>(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    throw core::DatasetError("bag " + path +
                             " has no index, its recording was interrupted; run: rosbag reindex " + path);
  } catch (const std::exception& error) {
    throw core::DatasetError(damagedBagText(path, error.what()));
  }
}

std::map<std::string, std::string> topicTypes(const rosbag::Bag& bag) {
  std::map<std::string, std::string> types;
  rosbag::View all(bag);
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    types[connection->topic] = connection->datatype;
  }
  return types;
}

std::string describeTopics(const std::map<std::string, std::string>& types) {
  std::vector<std::string> present;
  present.reserve(types.size());
  for (const auto& [topic, type] : types) present.push_back(topic + " (" + type + ")");
  return present.empty() ? "none" : core::joinList(present);
}

std::string stampText(const ros::Time& stamp) {
  std::ostringstream text;
  text << stamp;
  return text.str();
}

}  // namespace corrsel
