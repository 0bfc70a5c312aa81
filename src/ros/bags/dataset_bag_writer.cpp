#include "ros/bags/dataset_bag_writer.h"

#include <rosbag/bag.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

#include <cmath>
#include <filesystem>
#include <optional>
#include <set>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "ros/bags/bag_topics.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr char kLeftFrame[] = "left_camera_optical";
constexpr char kRightFrame[] = "right_camera_optical";
constexpr std::uint32_t kChunkBytes = 16u << 20;  // large chunks keep opening fast

std::string imageEncoding(const core::ImagePair& pair, const cv::Mat& image, const char* side) {
  if (image.empty()) throw core::DatasetError(pair.id.text() + ": the " + side + " image is missing");
  if (image.type() == CV_8UC1) return sensor_msgs::image_encodings::MONO8;
  if (image.type() == CV_8UC3) return sensor_msgs::image_encodings::BGR8;
  throw core::DatasetError(pair.id.text() + ": the " + side + " image is neither 8-bit grey nor 8-bit BGR");
}

}  // namespace

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
      throw core::DatasetError("cannot write " + part_path + ": " + error.what() + "; is the disk full?");
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
    throw core::DatasetError("cannot write " + impl_->part_path + ": " + error.what() +
                             "; does its folder exist?");
  }
}

DatasetBagWriter::~DatasetBagWriter() {
  if (!impl_ || impl_->part_path.empty()) return;
  try {
    impl_->bag.close();
  } catch (const std::exception&) {  // the file is removed anyway
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
  const auto frame = [](const std::string& name, const char* camera) {
    return name.empty() ? camera : kImageFrame + name;
  };
  info.header.frame_id = frame(pair.left_name, kLeftFrame);
  info.right_stamp = stamp;
  info.right_frame_id = frame(pair.right_name, kRightFrame);
  info.id = pair.id;
  info.features = "given";

  std_msgs::Header right_header = info.header;
  right_header.frame_id = info.right_frame_id;
  const bool images = !pair.given || !pair.left.empty() || !pair.right.empty();
  cv_bridge::CvImage left, right;
  if (images) {
    left = {info.header, imageEncoding(pair, pair.left, "left"), pair.left};
    right = {right_header, imageEncoding(pair, pair.right, "right"), pair.right};
  }

  GroundTruth truth = toMsg(pair.truth, info);
  truth.left_lens = toMsg(pair.left_camera);
  truth.right_lens = toMsg(pair.right_camera);
  impl_->write(bag_topics::kGroundTruth, stamp, truth);
  if (pair.given) impl_->write(bag_topics::kCorrespondences, stamp, toMsg(*pair.given, info));
  ++impl_->pairs;
  if (!images) return;
  if (impl_->options.compressed) {
    impl_->write(bag_topics::kLeftCompressed, stamp, toPngMsg(left.header, left.image));
    impl_->write(bag_topics::kRightCompressed, stamp, toPngMsg(right.header, right.image));
  } else {
    impl_->write(bag_topics::kLeft, stamp, *left.toImageMsg());
    impl_->write(bag_topics::kRight, stamp, *right.toImageMsg());
  }
}

void DatasetBagWriter::close() {
  if (impl_->part_path.empty()) return;
  try {
    impl_->bag.close();
    fs::rename(impl_->part_path, impl_->path);
  } catch (const std::exception& error) {
    throw core::DatasetError("cannot complete " + impl_->path + ": " + error.what());
  }
  impl_->part_path.clear();
}

std::size_t writeDatasetBag(const core::DatasetReader& reader, const std::string& path,
                            const DatasetBagOptions& options, const BagProgress& progress,
                            std::vector<UnreadablePair>* problems, std::vector<std::string>* remarks) {
  DatasetBagWriter writer(path, options);
  if (remarks != nullptr) *remarks = reader.remarks();
  std::set<int> stretched;
  std::size_t written = 0;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    std::optional<core::ImagePair> pair;
    try {
      pair = reader.read(i);
    } catch (const core::DatasetError& error) {
      if (problems != nullptr) problems->push_back({reader.id(i), error.what()});
    }
    if (pair) {
      const bool noticed = pair->stretched && stretched.insert(pair->stretched->bits).second;
      if (noticed && remarks != nullptr) remarks->push_back(pair->stretched->text());
      writer.write(*pair);
      ++written;
    }
    if (progress) progress(i + 1, reader.size(), reader.id(i));
  }
  if (written > 0) writer.close();
  return written;
}

}  // namespace corrsel
