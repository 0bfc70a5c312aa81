#include "ros/bags/dataset_bag.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "ros/bags/bag_file.h"
#include "ros/bags/own_bag.h"
#include "ros/bags/recorded_bag.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr char kLeftFrame[] = "left_camera_optical";
constexpr char kRightFrame[] = "right_camera_optical";
constexpr std::uint32_t kChunkBytes = 16u << 20;  // large chunks keep opening fast

/// Exceptions of rosbag and OpenCV as the one that callers of the core know.
[[noreturn]] void fail(const std::string& what) { throw core::DatasetError(what); }

std::string imageEncoding(const core::ImagePair& pair, const cv::Mat& image, const char* side) {
  if (image.type() == CV_8UC1) return sensor_msgs::image_encodings::MONO8;
  if (image.type() == CV_8UC3) return sensor_msgs::image_encodings::BGR8;
  fail(pair.id.text() + ": the " + side + " image is neither 8-bit grey nor 8-bit BGR");
}

}  // namespace

// ---------------------------------------------------------------------------------------------------- writer

struct DatasetBagWriter::Impl {
  std::string path, part_path;
  DatasetBagOptions options;
  rosbag::Bag bag;
  std::uint64_t pairs = 0;

  template <class Message>
  void write(const char* topic, const ros::Time& stamp, const Message& message) {
    try {
      bag.write(topic, stamp, message);
    } catch (const rosbag::BagException& error) {
      fail("cannot write " + part_path + ": " + error.what() + "; is the disk full?");
    }
  }
};

DatasetBagWriter::DatasetBagWriter(const std::string& path, const DatasetBagOptions& options)
    : impl_(std::make_unique<Impl>()) {
  if (!(options.period >= 1e-3 && options.period <= 3600.0)) {
    throw std::invalid_argument("period = " + core::formatNumber(options.period) +
                                " is outside [0.001, 3600] s");
  }
  impl_->path = path;
  impl_->part_path = path + ".part";
  impl_->options = options;
  try {
    impl_->bag.open(impl_->part_path, rosbag::bagmode::Write);
    impl_->bag.setCompression(rosbag::compression::LZ4);
    impl_->bag.setChunkThreshold(kChunkBytes);
  } catch (const rosbag::BagException& error) {
    fail("cannot write " + impl_->part_path + ": " + error.what() + "; does its folder exist?");
  }
}

DatasetBagWriter::~DatasetBagWriter() {
  if (!impl_ || impl_->part_path.empty()) return;
  try {
    impl_->bag.close();
  } catch (const std::exception&) {  // the file goes anyway
  }
  std::error_code ignored;
  fs::remove(impl_->part_path, ignored);
}

void DatasetBagWriter::write(const core::ImagePair& pair) {
  const auto step = static_cast<std::int64_t>(std::llround(impl_->options.period * 1e9));
  ros::Duration offset;
  offset.fromNSec(step * static_cast<std::int64_t>(impl_->pairs));
  const ros::Time stamp = impl_->options.start + offset;

  PairInfo info;
  info.header.stamp = stamp;
  info.header.frame_id = kLeftFrame;
  info.right_stamp = stamp;
  info.right_frame_id = kRightFrame;
  info.id = pair.id;
  info.features = "given";

  std_msgs::Header right_header = info.header;
  right_header.frame_id = kRightFrame;
  const cv_bridge::CvImage left(info.header, imageEncoding(pair, pair.left, "left"), pair.left);
  const cv_bridge::CvImage right(right_header, imageEncoding(pair, pair.right, "right"), pair.right);

  impl_->write(bag_topics::kGroundTruth, stamp, toMsg(pair.truth, info));
  if (pair.given) impl_->write(bag_topics::kCorrespondences, stamp, toMsg(*pair.given, info));
  if (impl_->options.compressed) {
    impl_->write(bag_topics::kLeftCompressed, stamp, *left.toCompressedImageMsg(cv_bridge::PNG));
    impl_->write(bag_topics::kRightCompressed, stamp, *right.toCompressedImageMsg(cv_bridge::PNG));
  } else {
    impl_->write(bag_topics::kLeft, stamp, *left.toImageMsg());
    impl_->write(bag_topics::kRight, stamp, *right.toImageMsg());
  }
  ++impl_->pairs;
}

void DatasetBagWriter::close() {
  if (impl_->part_path.empty()) return;
  try {
    impl_->bag.close();
    fs::rename(impl_->part_path, impl_->path);
  } catch (const std::exception& error) {
    fail("cannot complete " + impl_->path + ": " + error.what());
  }
  impl_->part_path.clear();
}

// ---------------------------------------------------------------------------------------------------- reader

namespace {

/// Reads dataset bags: a pair is what has one stamp.
class DatasetBagSource : public core::PairSource {
 public:
  DatasetBagSource(std::unique_ptr<rosbag::Bag> bag, const std::string& path);
  std::size_t size() const override { return n_pairs_; }
  bool next(core::ImagePair& pair) override;

 private:
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

  static Item read(const rosbag::MessageInstance& message);
  bool nextGroup(ros::Time& stamp, Group& group, std::string& problem);
  cv::Mat image(const Group& group, const std::string& topic, const core::PairId& id) const;
  void build(const ros::Time& stamp, const Group& group, core::ImagePair& pair) const;

  std::unique_ptr<rosbag::Bag> bag_;
  std::string path_;
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator position_;
  std::optional<Item> ahead_;  ///< the first message of the next pair, read already
  std::size_t n_pairs_ = 0;
  std::string left_topic_, right_topic_;  ///< raw ones, or the compressed ones where there are no raw ones
};

DatasetBagSource::Item DatasetBagSource::read(const rosbag::MessageInstance& message) {
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
bool DatasetBagSource::nextGroup(ros::Time& stamp, Group& group, std::string& problem) {
  const auto add = [&](Item&& item) {
    if (group.empty()) stamp = item.stamp;
    const std::string topic = item.topic;
    if (!group.emplace(topic, std::move(item)).second) {
      problem = topic + " has several messages with the stamp " + stampText(stamp);
    }
  };
  if (ahead_) {
    add(std::move(*ahead_));
    ahead_.reset();
  }
  for (; position_ != view_->end(); ++position_) {
    Item item = read(*position_);
    if (!group.empty() && item.stamp != stamp) {
      ahead_ = std::move(item);
      ++position_;
      break;
    }
    add(std::move(item));
  }
  return !group.empty();
}

cv::Mat DatasetBagSource::image(const Group& group, const std::string& topic, const core::PairId& id) const {
  const auto found = group.find(topic);
  if (found == group.end()) fail(id.text() + ": no message on " + topic);
  try {
    if (found->second.raw) return fromMsg(found->second.raw)->image.clone();
    return fromMsg(*found->second.compressed);
  } catch (const std::invalid_argument& error) {
    fail(id.text() + ": " + topic + ": " + error.what());
  }
}

void DatasetBagSource::build(const ros::Time& stamp, const Group& group, core::ImagePair& pair) const {
  const auto truth = group.find(bag_topics::kGroundTruth);
  const auto given = group.find(bag_topics::kCorrespondences);
  pair = {};
  pair.id = {fs::path(path_).stem().string(), "bag", stampText(stamp)};
  if (given != group.end() && given->second.given && !given->second.given->pair.empty()) {
    const Correspondences& msg = *given->second.given;
    pair.id = {msg.dataset, msg.sequence, msg.pair};
  }
  if (truth != group.end() && truth->second.truth) {
    const GroundTruth& msg = *truth->second.truth;
    pair.id = {msg.dataset, msg.sequence, msg.pair};
  }

  for (const auto& [topic, item] : group) {
    if (!item.error.empty()) fail(pair.id.text() + ": " + topic + " " + item.error);
  }
  const char* topic = bag_topics::kGroundTruth;
  try {
    if (truth != group.end()) pair.truth = fromMsg(*truth->second.truth);
    topic = bag_topics::kCorrespondences;
    if (given != group.end()) pair.given = fromMsg(*given->second.given);
  } catch (const std::invalid_argument& error) {
    fail(pair.id.text() + ": " + topic + ": " + error.what());
  }
  pair.left = image(group, left_topic_, pair.id);
  pair.right = image(group, right_topic_, pair.id);
}

DatasetBagSource::DatasetBagSource(std::unique_ptr<rosbag::Bag> bag, const std::string& path)
    : bag_(std::move(bag)), path_(path) {
  const std::map<std::string, std::string> topics = topicTypes(*bag_);
  const auto choose = [&topics](const char* raw, const char* compressed) -> std::string {
    if (topics.count(raw) != 0) return raw;
    return topics.count(compressed) != 0 ? compressed : "";
  };
  left_topic_ = choose(bag_topics::kLeft, bag_topics::kLeftCompressed);
  right_topic_ = choose(bag_topics::kRight, bag_topics::kRightCompressed);
  if (left_topic_.empty() || right_topic_.empty()) {
    fail("bag " + path + " needs the topics " + bag_topics::kLeft + " and " + bag_topics::kRight +
         ", raw or /compressed, or left and right to name others; it has " + describeTopics(topics));
  }
  const auto count = [this](const std::string& topic) {
    return rosbag::View(*bag_, rosbag::TopicQuery(topic)).size();
  };
  n_pairs_ = std::max(count(left_topic_), count(bag_topics::kGroundTruth));
  view_ = std::make_unique<rosbag::View>(
      *bag_, rosbag::TopicQuery(std::vector<std::string>{left_topic_, right_topic_, bag_topics::kGroundTruth,
                                                         bag_topics::kCorrespondences}));
  position_ = view_->begin();
}

bool DatasetBagSource::next(core::ImagePair& pair) {
  ros::Time stamp;
  Group group;
  std::string problem;
  if (!nextGroup(stamp, group, problem)) return false;
  build(stamp, group, pair);
  if (!problem.empty()) fail(pair.id.text() + ": " + problem);
  return true;
}

bool namesTopics(const BagTopics& topics) {
  return !topics.left.empty() || !topics.right.empty() || !topics.left_info.empty() ||
         !topics.right_info.empty() || !topics.ground_truth.empty();
}

}  // namespace

BagSource::BagSource(const std::string& path, const BagTopics& topics) {
  std::unique_ptr<rosbag::Bag> bag = openBag(path);
  try {
    const std::map<std::string, std::string> types = topicTypes(*bag);
    const bool names_images = !topics.left.empty() || !topics.right.empty();
    if (!topics.correspondences.empty() || (!names_images && RecordedMatchesSource::recognises(types))) {
      auto recorded = std::make_unique<RecordedMatchesSource>(std::move(bag), path, topics);
      notes_ = recorded->notes();
      source_ = std::move(recorded);
    } else if (namesTopics(topics) || OwnBagSource::recognises(types)) {
      auto own = std::make_unique<OwnBagSource>(std::move(bag), path, topics);
      notes_ = own->notes();
      source_ = std::move(own);
    } else {
      source_ = std::make_unique<DatasetBagSource>(std::move(bag), path);
    }
  } catch (const rosbag::BagException& error) {
    fail(damagedBagText(path, error.what()));
  }
}

BagSource::~BagSource() = default;

std::size_t BagSource::size() const { return source_->size(); }

bool BagSource::next(core::ImagePair& pair) { return source_->next(pair); }

const std::vector<std::string>& BagSource::notes() const { return notes_; }

// ------------------------------------------------------------------------------------------------ conversion

std::size_t writeDatasetBag(const core::DatasetReader& reader, const std::string& path,
                            const DatasetBagOptions& options, const BagProgress& progress,
                            std::vector<std::string>* problems) {
  DatasetBagWriter writer(path, options);
  std::size_t written = 0;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    std::optional<core::ImagePair> pair;
    try {
      pair = reader.read(i);
    } catch (const core::DatasetError& error) {
      if (problems != nullptr) problems->push_back(reader.id(i).text() + ": " + error.what());
    }
    if (pair) {
      writer.write(*pair);
      ++written;
    }
    if (progress) progress(i + 1, reader.size(), reader.id(i));
  }
  if (written > 0) writer.close();
  return written;
}

}  // namespace corrsel
