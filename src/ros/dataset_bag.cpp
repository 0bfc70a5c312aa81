#include "corrsel/ros/dataset_bag.h"

#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "corrsel/ros/conversions.h"
#include "corrsel/text.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr char kLeftFrame[] = "left_camera_optical";
constexpr char kRightFrame[] = "right_camera_optical";
constexpr std::uint32_t kChunkBytes = 16u << 20;  // large chunks keep opening fast

/// Exceptions of rosbag and OpenCV as the one that callers of the core know.
[[noreturn]] void fail(const std::string& what) { throw core::DatasetError(what); }

std::string stampText(const ros::Time& stamp) {
  std::ostringstream text;
  text << stamp;  // seconds.nanoseconds, nine digits
  return text.str();
}

bool looksLikeBag(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string magic(8, '\0');
  file.read(magic.data(), static_cast<std::streamsize>(magic.size()));
  return file && magic == "#ROSBAG ";
}

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

struct BagSource::Impl {
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

  std::string path;
  rosbag::Bag bag;
  std::unique_ptr<rosbag::View> view;
  rosbag::View::iterator position;
  std::optional<Item> ahead;  ///< the first message of the next pair, read already
  std::size_t n_pairs = 0;
  std::string left_topic, right_topic;  ///< raw ones, or the compressed ones where there are no raw ones

  void open();
  std::map<std::string, std::string> topics();
  Item read(const rosbag::MessageInstance& message) const;
  bool nextGroup(ros::Time& stamp, Group& group, std::string& problem);
  cv::Mat image(const Group& group, const std::string& topic, const core::PairId& id) const;
  void build(const ros::Time& stamp, const Group& group, core::ImagePair& pair) const;
};

void BagSource::Impl::open() {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) fail("bag " + path + " does not exist or is not a file");
  if (!looksLikeBag(path)) fail(path + " is not a bag: it does not begin with '#ROSBAG'");
  try {
    bag.open(path, rosbag::bagmode::Read);
  } catch (const rosbag::BagUnindexedException&) {
    fail("bag " + path + " has no index, its recording was interrupted; run: rosbag reindex " + path);
  } catch (const std::exception& error) {
    fail("bag " + path + " is cut off or damaged (" + error.what() + "); run: rosbag reindex " + path);
  }
}

std::map<std::string, std::string> BagSource::Impl::topics() {
  std::map<std::string, std::string> types;
  rosbag::View all(bag);
  for (const rosbag::ConnectionInfo* connection : all.getConnections()) {
    types[connection->topic] = connection->datatype;
  }
  return types;
}

BagSource::Impl::Item BagSource::Impl::read(const rosbag::MessageInstance& message) const {
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
bool BagSource::Impl::nextGroup(ros::Time& stamp, Group& group, std::string& problem) {
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

cv::Mat BagSource::Impl::image(const Group& group, const std::string& topic, const core::PairId& id) const {
  const auto found = group.find(topic);
  if (found == group.end()) fail(id.text() + ": no message on " + topic);
  try {
    if (found->second.raw) return fromMsg(found->second.raw)->image.clone();
    return fromMsg(*found->second.compressed);
  } catch (const std::invalid_argument& error) {
    fail(id.text() + ": " + topic + ": " + error.what());
  }
}

void BagSource::Impl::build(const ros::Time& stamp, const Group& group, core::ImagePair& pair) const {
  const auto truth = group.find(bag_topics::kGroundTruth);
  const auto given = group.find(bag_topics::kCorrespondences);
  pair = {};
  pair.id = {fs::path(path).stem().string(), "bag", stampText(stamp)};
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
  pair.left = image(group, left_topic, pair.id);
  pair.right = image(group, right_topic, pair.id);
}

BagSource::BagSource(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->open();
  try {
    const std::map<std::string, std::string> topics = impl_->topics();
    const auto choose = [&topics](const char* raw, const char* compressed) -> std::string {
      if (topics.count(raw) != 0) return raw;
      return topics.count(compressed) != 0 ? compressed : "";
    };
    impl_->left_topic = choose(bag_topics::kLeft, bag_topics::kLeftCompressed);
    impl_->right_topic = choose(bag_topics::kRight, bag_topics::kRightCompressed);
    if (impl_->left_topic.empty() || impl_->right_topic.empty()) {
      std::vector<std::string> present;
      for (const auto& [topic, type] : topics) present.push_back(topic + " (" + type + ")");
      fail("bag " + path + " needs the topics " + bag_topics::kLeft + " and " + bag_topics::kRight +
           ", raw or /compressed; it has " + (present.empty() ? "none" : core::joinList(present)));
    }
    const auto count = [this](const std::string& topic) {
      return rosbag::View(impl_->bag, rosbag::TopicQuery(topic)).size();
    };
    impl_->n_pairs = std::max(count(impl_->left_topic), count(bag_topics::kGroundTruth));
    impl_->view = std::make_unique<rosbag::View>(
        impl_->bag,
        rosbag::TopicQuery(std::vector<std::string>{impl_->left_topic, impl_->right_topic,
                                                    bag_topics::kGroundTruth, bag_topics::kCorrespondences}));
    impl_->position = impl_->view->begin();
  } catch (const rosbag::BagException& error) {
    fail("bag " + path + " is cut off or damaged (" + error.what() + "); run: rosbag reindex " + path);
  }
}

BagSource::~BagSource() = default;

std::size_t BagSource::size() const { return impl_->n_pairs; }

bool BagSource::next(core::ImagePair& pair) {
  ros::Time stamp;
  Impl::Group group;
  std::string problem;
  if (!impl_->nextGroup(stamp, group, problem)) return false;
  impl_->build(stamp, group, pair);
  if (!problem.empty()) fail(pair.id.text() + ": " + problem);
  return true;
}

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
