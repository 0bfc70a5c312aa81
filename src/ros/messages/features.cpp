#include "corrsel/ros/features.h"

#include <cstring>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "features/parts/feature_list.h"
#include "ros/messages/fields.h"

namespace corrsel {
namespace {

const std::string kName = "Features";

/// How the elements of descriptors are stored. Numbers of 16 bits have no type that OpenCV converts.
struct Storage {
  int type;           ///< of OpenCV
  std::size_t bytes;  ///< of an element
};

Storage storageOf(std::uint8_t descriptor_type) {
  switch (descriptor_type) {
    case Features::DESCRIPTOR_BINARY:
    case Features::DESCRIPTOR_UINT8:
      return {CV_8U, 1};
    case Features::DESCRIPTOR_INT8:
      return {CV_8S, 1};
    case Features::DESCRIPTOR_FLOAT16:
      return {CV_16S, 2};
    case Features::DESCRIPTOR_FLOAT32:
      return {CV_32F, 4};
    case Features::DESCRIPTOR_FLOAT64:
      return {CV_64F, 8};
    default:
      refuse(kName, "descriptor_type",
             "is " + std::to_string(descriptor_type) + ", which is unknown; use one of DESCRIPTOR_*");
  }
}

/// The descriptors, N x D: CV_8U where they are binary, otherwise CV_32F.
cv::Mat readDescriptors(const Features& msg) {
  const Storage storage = storageOf(msg.descriptor_type);
  const std::size_t n = msg.x.size(), row = msg.descriptor_length * storage.bytes;
  if (msg.descriptors.empty()) return {};
  if (msg.descriptors.size() != n * row || msg.descriptor_length > kMaxImageSide) {
    refuse(kName, "descriptors",
           "has " + std::to_string(msg.descriptors.size()) + " bytes, expected " + std::to_string(n) +
               " rows of descriptor_length = " + std::to_string(msg.descriptor_length) + " elements of " +
               std::to_string(storage.bytes) + " bytes");
  }
  cv::Mat stored(static_cast<int>(n), static_cast<int>(msg.descriptor_length), storage.type);
  std::memcpy(stored.data, msg.descriptors.data(), msg.descriptors.size());
  if (msg.descriptor_type == Features::DESCRIPTOR_BINARY || storage.type == CV_32F) return stored;
  cv::Mat numbers;
  if (msg.descriptor_type == Features::DESCRIPTOR_FLOAT16) {
    cv::convertFp16(stored, numbers);
  } else {
    stored.convertTo(numbers, CV_32F);
  }
  return numbers;
}

std::vector<cv::KeyPoint> readKeypoints(const Features& msg) {
  std::vector<cv::KeyPoint> keypoints(msg.x.size());
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    keypoints[i].pt = {msg.x[i], msg.y[i]};
    if (!msg.size.empty()) keypoints[i].size = msg.size[i];
    if (!msg.angle.empty()) keypoints[i].angle = msg.angle[i];
    if (!msg.score.empty()) keypoints[i].response = msg.score[i];
  }
  return keypoints;
}

}  // namespace

Features toMsg(const core::Features& features, const FeatureInfo& info) {
  const cv::Mat& descriptors = features.descriptors;
  if (!descriptors.empty() && static_cast<std::size_t>(descriptors.rows) != features.keypoints.size()) {
    throw std::invalid_argument(std::to_string(descriptors.rows) + " descriptors of " +
                                std::to_string(features.keypoints.size()) + " keypoints");
  }
  if (!descriptors.empty() && descriptors.type() != CV_8U && descriptors.type() != CV_32F) {
    throw std::invalid_argument("descriptors are " + cv::typeToString(descriptors.type()) +
                                "; needed: CV_8U or CV_32F");
  }
  Features msg;
  msg.header = info.header;
  msg.features = info.name;
  msg.width = static_cast<std::uint32_t>(features.image_size.width);
  msg.height = static_cast<std::uint32_t>(features.image_size.height);
  msg.camera = toMsg(info.camera);
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    msg.x.push_back(keypoint.pt.x);
    msg.y.push_back(keypoint.pt.y);
    msg.size.push_back(keypoint.size);
    msg.angle.push_back(keypoint.angle);
    msg.score.push_back(keypoint.response);
  }
  msg.descriptor_type =
      descriptors.type() == CV_8U ? Features::DESCRIPTOR_BINARY : Features::DESCRIPTOR_FLOAT32;
  msg.descriptor_length = static_cast<std::uint32_t>(descriptors.cols);
  const std::size_t row = descriptors.cols * descriptors.elemSize();
  for (int i = 0; i < descriptors.rows; ++i) {
    msg.descriptors.insert(msg.descriptors.end(), descriptors.ptr(i), descriptors.ptr(i) + row);
  }
  msg.seconds = info.seconds;
  return msg;
}

core::Features fromMsg(const Features& msg, FeatureInfo* info) {
  const std::size_t n = msg.x.size();
  requireLength(kName, "y", msg.y.size(), n, false);
  requireLength(kName, "size", msg.size.size(), n, true);
  requireLength(kName, "angle", msg.angle.size(), n, true);
  requireLength(kName, "score", msg.score.size(), n, true);
  core::Features features;
  features.image_size = imageSize(kName, "", msg.width, msg.height);
  features.keypoints = readKeypoints(msg);
  if (!msg.size.empty() && !msg.angle.empty()) features.frames = core::similarityFrames(features.keypoints);
  features.descriptors = readDescriptors(msg);
  if (info != nullptr)
    *info = {msg.header, msg.features, readCamera(kName, "camera", msg.camera), msg.seconds};
  return features;
}

}  // namespace corrsel
