#include "ros/bags/dataset_bag.h"

#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "corrsel/ros/conversions.h"
#include "datasets/stretching.h"
#include "ros/bags/bag_topics.h"

namespace corrsel {
struct DatasetBagSource::Impl {
  /// One message, taken out of the bag.
  struct Item {
    ros::Time stamp;
    std::string topic;
    sensor_msgs::ImageConstPtr raw;
    sensor_msgs::CompressedImageConstPtr compressed;
    GroundTruthConstPtr truth;
    CorrespondencesConstPtr given;
    std::string error;  ///< why the message could not be read
  };
  /// The messages of one stamp, by topic.
  using Group = std::map<std::string, Item>;
  /// The name that the frame id of an image gives; empty where there is none.
  static std::string imageNameIn(const Group& group, const std::string& topic) {
    const auto found = group.find(topic);
    if (found == group.end()) return "";
    const Item& item = found->second;
    return imageName(item.raw ? item.raw->header.frame_id : item.compressed->header.frame_id);
  }

  explicit Impl(BagFile bag);
  static Item read(const rosbag::MessageInstance& message);
  bool nextGroup(ros::Time& stamp, Group& group, std::string& problem);
  core::StoredImage image(const Group& group, const std::string& topic, const core::PairId& id) const;
  void build(const ros::Time& stamp, const Group& group, core::ImagePair& pair) const;

  BagFile file;
  std::unique_ptr<rosbag::View> view;
  rosbag::View::iterator position;
  std::optional<Item> ahead;  ///< the first message of the next pair, which has been read already
  std::size_t n_pairs = 0;
  std::string left_topic, right_topic;  ///< raw ones, or the compressed ones where there are no raw ones
};

DatasetBagSource::Impl::Item DatasetBagSource::Impl::read(const rosbag::MessageInstance& message) {
  Item item;
  item.topic = message.getTopic();
  item.stamp = message.getTime();
  const auto take = [&](auto& slot) {
    using Message = std::decay_t<decltype(*slot)>;
    const auto instance = message.instantiate<Message>();
    if (instance == nullptr) {  // another type, or another version of the type
      item.error = "has type " + message.getDataType() + " with checksum " + message.getMD5Sum();
      return;
    }
    item.stamp = instance->header.stamp;
    slot = instance;
  };
  try {
    if (item.topic == bag_topics::kGroundTruth) {
      take(item.truth);
    } else if (item.topic == bag_topics::kCorrespondences) {
      take(item.given);
    } else if (item.topic == bag_topics::kLeft || item.topic == bag_topics::kRight) {
      take(item.raw);
    } else {
      take(item.compressed);
    }
  } catch (const std::exception& error) {  // a damaged chunk
    item.error = std::string("cannot be read (") + error.what() + ")";
  }
  return item;
}

/// Collects the messages up to the next stamp. @return false at the end of the bag
bool DatasetBagSource::Impl::nextGroup(ros::Time& stamp, Group& group, std::string& problem) {
  const auto add = [&](Item&& item) {
    if (group.empty()) stamp = item.stamp;
    const std::string topic = item.topic;
    if (!group.emplace(topic, std::move(item)).second) {
      problem = topic + " has several messages with the stamp " + stampText(stamp);
    }
  };
  if (ahead) {
    add(std::move(*ahead));
    ahead.reset();
  }
  for (; position != view->end(); ++position) {
    Item item = read(*position);
    if (!group.empty() && item.stamp != stamp) {
      ahead = std::move(item);
      ++position;
      break;
    }
    add(std::move(item));
  }
  return !group.empty();
}

core::StoredImage DatasetBagSource::Impl::image(const Group& group, const std::string& topic,
                                                const core::PairId& id) const {
  return {topic, [&group, &topic, &id](bool all_bits) -> cv::Mat {
            const auto found = group.find(topic);
            if (found == group.end()) throw core::DatasetError(id.text() + ": no message on " + topic);
            const Item& item = found->second;
            try {
              if (!item.raw) return all_bits ? fromMsgInAllBits(*item.compressed) : fromMsg(*item.compressed);
              return (all_bits ? fromMsgInAllBits(item.raw) : fromMsg(item.raw))->image.clone();
            } catch (const std::invalid_argument& error) {
              throw core::DatasetError(id.text() + ": " + topic + ": " + error.what());
            }
          }};
}

void DatasetBagSource::Impl::build(const ros::Time& stamp, const Group& group, core::ImagePair& pair) const {
  const auto truth = group.find(bag_topics::kGroundTruth);
  const auto given = group.find(bag_topics::kCorrespondences);
  pair = {};
  pair.id = file.idAt(static_cast<std::int64_t>(stamp.toNSec()));
  if (given != group.end() && given->second.given && !given->second.given->pair.empty()) {
    const Correspondences& msg = *given->second.given;
    pair.id = {msg.dataset, msg.sequence, msg.pair};
  }
  if (truth != group.end() && truth->second.truth) {
    const GroundTruth& msg = *truth->second.truth;
    pair.id = {msg.dataset, msg.sequence, msg.pair};
  }

  for (const auto& [topic, item] : group) {
    if (!item.error.empty()) throw core::DatasetError(pair.id.text() + ": " + topic + " " + item.error);
  }
  const char* topic = bag_topics::kGroundTruth;
  try {
    if (truth != group.end()) {
      pair.truth = fromMsg(*truth->second.truth);
      pair.left_camera = fromMsg(truth->second.truth->left_lens);
      pair.right_camera = fromMsg(truth->second.truth->right_lens);
    }
    topic = bag_topics::kCorrespondences;
    if (given != group.end()) pair.given = fromMsg(*given->second.given);
  } catch (const std::invalid_argument& error) {
    throw core::DatasetError(pair.id.text() + ": " + topic + ": " + error.what());
  }
  pair.left_name = imageNameIn(group, left_topic);
  pair.right_name = imageNameIn(group, right_topic);
  if (given != group.end()) {
    pair.left_name = imageName(given->second.given->header.frame_id);
    pair.right_name = imageName(given->second.given->right_frame_id);
  }
  const bool images = group.count(left_topic) != 0 || group.count(right_topic) != 0;
  if (pair.given && !images) return;
  core::readStretched(image(group, left_topic, pair.id), image(group, right_topic, pair.id), pair);
}

DatasetBagSource::Impl::Impl(BagFile bag) : file(std::move(bag)) {
  const auto choose = [this](const char* raw, const char* compressed) -> std::string {
    if (file.types().count(raw) != 0) return raw;
    return file.types().count(compressed) != 0 ? compressed : "";
  };
  left_topic = choose(bag_topics::kLeft, bag_topics::kLeftCompressed);
  right_topic = choose(bag_topics::kRight, bag_topics::kRightCompressed);
  if (left_topic.empty() || right_topic.empty()) {
    throw core::DatasetError(
        "bag " + file.path() + " needs the topics " + bag_topics::kLeft + " and " + bag_topics::kRight +
        ", raw or /compressed, or left and right to name others; it has " + file.describeTopics());
  }
  try {
    n_pairs = std::max(file.count(left_topic), file.count(bag_topics::kGroundTruth));
    view = std::make_unique<rosbag::View>(
        file.bag(), rosbag::TopicQuery(std::vector<std::string>{
                        left_topic, right_topic, bag_topics::kGroundTruth, bag_topics::kCorrespondences}));
    position = view->begin();
  } catch (const rosbag::BagException& error) {
    file.failDamaged(error);
  }
}

DatasetBagSource::DatasetBagSource(BagFile file) : impl_(std::make_unique<Impl>(std::move(file))) {}

DatasetBagSource::~DatasetBagSource() = default;

std::size_t DatasetBagSource::size() const { return impl_->n_pairs; }

bool DatasetBagSource::next(core::ImagePair& pair) {
  ros::Time stamp;
  Impl::Group group;
  std::string problem;
  if (!impl_->nextGroup(stamp, group, problem)) return false;
  impl_->build(stamp, group, pair);
  if (!problem.empty()) throw core::DatasetError(pair.id.text() + ": " + problem);
  return true;
}

}  // namespace corrsel
