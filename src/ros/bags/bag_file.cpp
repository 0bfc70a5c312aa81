#include "ros/bags/bag_file.h"

#include <rosbag/view.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "base/text.h"
#include "corrsel/benchmark/config.h"
#include "corrsel/datasets/reader.h"

namespace corrsel {
namespace {

bool looksLikeBag(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic(8, '\0');
  file.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  return file && magic == "#ROSBAG ";
}

core::DatasetError damaged(const std::string& path, const std::string& what) {
  return core::DatasetError("bag " + path + " is cut off or damaged (" + what + "); run: rosbag reindex " +
                            path);
}

std::unique_ptr<rosbag::Bag> openFile(const std::string& path) {
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
    throw damaged(path, error.what());
  }
}

}  // namespace

BagFile::BagFile(const std::string& path) : path_(path), bag_(openFile(path)) {
  try {
    rosbag::View all(*bag_);
    for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
      types_[connection->topic] = connection->datatype;
    }
  } catch (const rosbag::BagException& error) {
    failDamaged(error);
  }
}

bool BagFile::has(const std::string& topic, const std::string& type) const {
  const auto found = types_.find(topic);
  return found != types_.end() && found->second == type;
}

std::string BagFile::find(const std::string& topic) const {
  if (types_.count(topic) != 0) return topic;
  const std::string other = !topic.empty() && topic[0] == '/' ? topic.substr(1) : "/" + topic;
  return types_.count(other) != 0 ? other : "";
}

std::string BagFile::find(const std::string& topic, const std::string& type) const {
  const std::string found = find(topic);
  return has(found, type) ? found : "";
}

std::vector<std::string> BagFile::topicsOfType(const std::string& type) const {
  std::vector<std::string> topics;
  for (const auto& [topic, its_type] : types_) {
    if (its_type == type) topics.push_back(topic);
  }
  return topics;
}

std::size_t BagFile::count(const std::string& topic) const {
  return rosbag::View(*bag_, rosbag::TopicQuery(topic)).size();
}

std::string BagFile::describeTopics() const {
  std::vector<std::string> present;
  present.reserve(types_.size());
  for (const auto& [topic, type] : types_) present.push_back(topic + " (" + type + ")");
  return present.empty() ? "none" : core::joinList(present);
}

core::PairId BagFile::idAt(std::int64_t stamp) const {
  ros::Time time;
  time.fromNSec(static_cast<std::uint64_t>(stamp));
  return {core::bagName(path_), "bag", stampText(time)};
}

void BagFile::failDamaged(const rosbag::BagException& error) const { throw damaged(path_, error.what()); }

std::string stampText(const ros::Time& stamp) {
  std::ostringstream text;
  text << stamp;
  return text.str();
}

}  // namespace corrsel
