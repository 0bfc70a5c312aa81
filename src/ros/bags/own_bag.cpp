#include "ros/bags/own_bag.h"

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/ros/cameras.h"
#include "corrsel/ros/conversions.h"
#include "datasets/stretching.h"
#include "ros/bags/bag_scan.h"
#include "ros/bags/rig_truth.h"
#include "ros/bags/stereo_rig.h"

namespace corrsel {
namespace {

constexpr char kImageType[] = "sensor_msgs/Image";
constexpr char kCompressedType[] = "sensor_msgs/CompressedImage";
constexpr char kCompressedSuffix[] = "/compressed";

std::string withoutCompressed(const std::string& topic) {
  const std::string suffix = kCompressedSuffix;
  const bool ends =
      topic.size() > suffix.size() && topic.compare(topic.size() - suffix.size(), suffix.size(), suffix) == 0;
  return ends ? topic.substr(0, topic.size() - suffix.size()) : topic;
}

/// "/stereo/left/image_raw" and its compressed form give "/stereo/left/camera_info".
std::string besideImage(const std::string& topic) {
  const std::string base = withoutCompressed(topic);
  const std::size_t slash = base.rfind('/');
  return (slash == std::string::npos ? "" : base.substr(0, slash + 1)) + "camera_info";
}

/// The topic, raw or compressed, with the images of this name; empty if there are none.
std::string imageTopic(const BagFile& file, const std::string& given) {
  const std::string base = withoutCompressed(given);
  for (const std::string& name : {given, base, base + kCompressedSuffix}) {
    std::string topic = file.find(name);
    if (file.has(topic, kImageType) || file.has(topic, kCompressedType)) return topic;
  }
  return "";
}

/// What a bag holds about one camera.
struct CameraTopics {
  std::string topic;  ///< of the images
  bool rectified = false;
  std::vector<Stamped> images;
  Calibration calibration;

  /// The camera of the images as they are; nothing where camera_info is missing or wrong.
  std::optional<core::Camera> camera() const {
    try {
      if (calibration.info) return cameraOf(*calibration.info, rectified);
    } catch (const std::invalid_argument&) {  // makeRig() says what is wrong
    }
    return std::nullopt;
  }
};

}  // namespace

struct OwnBagSource::Impl {
  struct Pair {
    Stamped left, right;
    std::optional<Stamped> truth;
  };

  BagFile file;
  BagTopics options;
  std::vector<std::string>& notes;
  CameraTopics left, right;
  std::string truth_topic;  ///< empty: none
  std::vector<Stamped> truths;
  std::optional<RawRig> raw_rig;  ///< in place of `rig`, of raw images of fisheye lenses
  std::shared_ptr<const StereoRig> rig;
  std::vector<core::OtherReading> other_declarations;  ///< of the rig's images
  std::string rig_problem;                             ///< why there is no rig
  std::vector<Pair> pairs;
  std::size_t position = 0;

  Impl(BagFile bag, const BagTopics& topics, std::vector<std::string>& all_notes);
  void findTopics();
  CameraTopics findCamera(const std::string& side, const std::string& images, const std::string& info) const;
  void scan();
  void makeRig();
  void makePairs();
  void checkSizes() const;
  [[noreturn]] void failUnpaired(const Partners& found) const;
  [[noreturn]] void failWithoutTruth(const Partners& found) const;
  cv::Mat image(const CameraTopics& camera, const Stamped& message, bool all_bits) const;
  void read(const Pair& from, core::ImagePair& pair) const;
};

CameraTopics OwnBagSource::Impl::findCamera(const std::string& side, const std::string& images,
                                            const std::string& info) const {
  CameraTopics camera;
  camera.topic = imageTopic(file, images);
  if (camera.topic.empty()) {
    throw core::DatasetError("bag " + file.path() + " has no images for " + side + " on " + images +
                             ", raw or " + kCompressedSuffix + "; it has " + file.describeTopics());
  }
  camera.rectified = isRectified(options.images, camera.topic);
  if (!info.empty()) {
    camera.calibration.topic = namedInfoTopic(file, info, side);
  } else {
    const std::string usual = besideImage(camera.topic), found = file.find(usual, kInfoType);
    camera.calibration.topic = found.empty() ? usual : found;
  }
  return camera;
}

void OwnBagSource::Impl::findTopics() {
  left = findCamera("left", options.left.empty() ? bag_topics::kLeft : options.left, options.left_info);
  right = findCamera("right", options.right.empty() ? bag_topics::kRight : options.right, options.right_info);
  if (withoutCompressed(left.topic) == withoutCompressed(right.topic)) {
    throw core::DatasetError("left and right are both " + withoutCompressed(left.topic) +
                             ": a pair needs two cameras; bag " + file.path() + " has " +
                             file.describeTopics());
  }
  truth_topic = truthTopic(file, options.ground_truth, notes);
}

void OwnBagSource::Impl::scan() {
  std::vector<BagScan::Topic> topics = {{left.topic}, {right.topic}};
  if (!truth_topic.empty()) topics.push_back({truth_topic});
  BagScan scan(file, topics, {left.calibration.topic, right.calibration.topic});
  for (CameraTopics* camera : {&left, &right}) {
    camera->images = scan.take(camera->topic);
    camera->calibration = scan.calibration(camera->calibration.topic);
  }
  truths = scan.take(truth_topic);
  scan.describe(notes);
}

void OwnBagSource::Impl::makeRig() {
  std::vector<std::string> missing, present;
  for (const CameraTopics* camera : {&left, &right}) {
    (camera->calibration.info ? present : missing).push_back(camera->calibration.topic);
    describeChanges(camera->calibration, notes);
  }
  if (!missing.empty()) {
    rig_problem = "there is no camera_info on " + core::joinList(missing, " and ");
    if (!present.empty()) {
      rig_problem += ", while " + present.front() +
                     " has one, and one camera alone does not give the geometry of the pair";
    }
    return;
  }
  try {
    const RigCamera left_camera{*left.calibration.info, left.rectified, left.calibration.topic};
    const RigCamera right_camera{*right.calibration.info, right.rectified, right.calibration.topic};
    rig = std::make_shared<const StereoRig>(left_camera, right_camera);
    raw_rig = rawRigOf(left_camera, right_camera);
    if (raw_rig) {
      notes.push_back("images of fisheye lenses are not rectified: they are evaluated by their rays");
    } else {
      other_declarations = otherDeclarations(left_camera, right_camera, rig);
    }
  } catch (const std::invalid_argument& error) {
    rig_problem = error.what();
  }
}

void OwnBagSource::Impl::failUnpaired(const Partners& found) const {
  for (const CameraTopics* camera : {&left, &right}) {
    if (camera->images.empty())
      throw core::DatasetError("bag " + file.path() + " has no readable image on " + camera->topic);
  }
  throw core::DatasetError(
      "bag " + file.path() + ": no image on " + right.topic + " comes within " +
      core::formatNumber(options.max_stamp_difference) + " s of one on " + left.topic +
      "; the smallest difference of stamps is " + secondsText(found.min_difference) +
      (found.min_difference > static_cast<std::int64_t>(BagTopics::kMaxStampDifference * 1e9)
           ? ": are the clocks of the cameras set?"
           : ": set max_stamp_difference to at least that"));
}

void OwnBagSource::Impl::failWithoutTruth(const Partners& found) const {
  std::string truth_problem =
      "there is no " + std::string(kTruthType) + " on " +
      (options.ground_truth.empty() ? bag_topics::kGroundTruth : options.ground_truth);
  if (!truths.empty()) {
    truth_problem = "no message on " + truth_topic +
                    " has the stamp of a left image (the smallest difference is " +
                    secondsText(found.min_difference) + ")";
  }
  throw core::DatasetError("bag " + file.path() + " has no ground truth: " + rig_problem + "; and " +
                           truth_problem + "; it has " + file.describeTopics());
}

void OwnBagSource::Impl::makePairs() {
  const Partners rights = partners(stampsOf(left.images), stampsOf(right.images), tolerance(options));
  if (rights.size() == 0) failUnpaired(rights);
  std::vector<std::int64_t> paired;
  for (std::size_t i = 0; i < left.images.size(); ++i) {
    if (rights.of[i]) paired.push_back(left.images[i].stamp);
  }
  const Partners evaluated = partners(paired, stampsOf(truths), tolerance(options));
  if (!rig && evaluated.size() == 0) failWithoutTruth(evaluated);

  std::size_t k = 0, without_truth = 0;
  for (std::size_t i = 0; i < left.images.size(); ++i) {
    if (!rights.of[i]) continue;
    const std::optional<std::size_t> truth = evaluated.of[k++];
    if (!truth && !rig) {
      ++without_truth;
      continue;
    }
    pairs.push_back({left.images[i], right.images[*rights.of[i]], std::nullopt});
    if (truth) pairs.back().truth.emplace(truths[*truth]);
  }
  if (paired.size() < left.images.size()) {
    notes.push_back(std::to_string(left.images.size() - paired.size()) + " of " +
                    count(left.images.size(), "left image") + " have no right image within " +
                    core::formatNumber(options.max_stamp_difference) + " s and are left out");
  }
  if (without_truth > 0) {
    notes.push_back(std::to_string(without_truth) + " of " + count(paired.size(), "pair") +
                    " have no message on " + truth_topic + " and are left out, since " + rig_problem);
  } else if (evaluated.size() > 0 && evaluated.size() < paired.size()) {
    notes.push_back(std::to_string(evaluated.size()) + " of " + count(paired.size(), "pair") +
                    " are evaluated with " + truth_topic + ", the others with camera_info");
  }
  if (evaluated.size() < truths.size()) {
    notes.push_back(std::to_string(truths.size() - evaluated.size()) + " of " +
                    count(truths.size(), "message") + " on " + truth_topic + " belong to no pair");
  }
}

/// The first pair that is evaluated with the rig shows whether camera_info belongs to the images.
void OwnBagSource::Impl::checkSizes() const {
  const auto first =
      std::find_if(pairs.begin(), pairs.end(), [](const Pair& pair) { return !pair.truth.has_value(); });
  if (first == pairs.end()) return;
  cv::Mat left_image, right_image;
  try {
    left_image = image(left, first->left, false);
    right_image = image(right, first->right, false);
  } catch (const std::exception&) {  // next() reports it
    return;
  }
  const auto check = [this](const CameraTopics& camera, const auto& rectify) {
    try {
      rectify();
    } catch (const std::invalid_argument& error) {
      throw core::DatasetError("bag " + file.path() + ": " + camera.topic + ": " + error.what());
    }
  };
  check(left, [&] { rig->rectifyLeft(left_image); });
  check(right, [&] { rig->rectifyRight(right_image); });
}

/// Throws std::invalid_argument or an exception of rosbag.
cv::Mat OwnBagSource::Impl::image(const CameraTopics& camera, const Stamped& message, bool all_bits) const {
  if (file.has(camera.topic, kImageType)) {
    const sensor_msgs::ImageConstPtr raw = message.message.instantiate<sensor_msgs::Image>();
    if (raw != nullptr) return (all_bits ? fromMsgInAllBits(raw) : fromMsg(raw))->image.clone();
  } else {
    const auto compressed = message.message.instantiate<sensor_msgs::CompressedImage>();
    if (compressed != nullptr) return all_bits ? fromMsgInAllBits(*compressed) : fromMsg(*compressed);
  }
  throw std::invalid_argument("has type " + message.message.getDataType() + " with checksum " +
                              message.message.getMD5Sum());
}

void OwnBagSource::Impl::read(const Pair& from, core::ImagePair& pair) const {
  pair = {};
  pair.id = file.idAt(from.left.stamp);
  const std::string* topic = &left.topic;
  try {
    const auto stored = [&](const CameraTopics& camera, const Stamped& message) {
      return core::StoredImage{camera.topic, [&](bool all_bits) {
                                 topic = &camera.topic;
                                 return image(camera, message, all_bits);
                               }};
    };
    core::readStretched(stored(left, from.left), stored(right, from.right), pair);
    if (!from.truth && raw_rig) {
      pair.left_camera = raw_rig->left;
      pair.right_camera = raw_rig->right;
      pair.truth = raw_rig->truth;
      return;
    }
    if (!from.truth) {
      topic = &left.topic;
      pair.left = rig->rectifyLeft(pair.left);
      topic = &right.topic;
      pair.right = rig->rectifyRight(pair.right);
      pair.truth = truthOf(*rig);
      pair.left_camera = core::cameraFromOpenCv(rig->pose().left_camera, {}, pair.left.size());
      pair.right_camera = core::cameraFromOpenCv(rig->pose().right_camera, {}, pair.right.size());
      pair.other_readings = other_declarations;
      return;
    }
    topic = &truth_topic;
    pair.truth = readTruth(from.truth->message);
    pair.left_camera = left.camera();
    pair.right_camera = right.camera();
  } catch (const std::exception& error) {  // also a damaged chunk
    throw core::DatasetError(pair.id.text() + ": " + *topic + ": " + error.what());
  }
}

OwnBagSource::Impl::Impl(BagFile bag, const BagTopics& topics, std::vector<std::string>& all_notes)
    : file(std::move(bag)), options(topics), notes(all_notes) {
  options.check();
  findTopics();
  scan();
  makeRig();
  makePairs();
  checkSizes();
}

OwnBagSource::OwnBagSource(BagFile file, const BagTopics& topics)
    : impl_(std::make_unique<Impl>(std::move(file), topics, notes_)) {
  const auto by_rig = std::count_if(impl_->pairs.begin(), impl_->pairs.end(),
                                    [](const Impl::Pair& pair) { return !pair.truth.has_value(); });
  evaluated_by_calibration_ = calibrationText(static_cast<std::size_t>(by_rig), impl_->pairs.size(),
                                              impl_->left.calibration, impl_->right.calibration);
}

OwnBagSource::~OwnBagSource() = default;

bool OwnBagSource::recognises(const BagFile& file) {
  for (const char* const topic : {bag_topics::kGroundTruth, bag_topics::kCorrespondences}) {
    if (file.types().count(topic) != 0) return false;
  }
  for (const char* const topic : {bag_topics::kLeft, bag_topics::kRight}) {
    if (imageTopic(file, topic).empty() || !file.has(besideImage(topic), kInfoType)) return false;
  }
  return true;
}

std::size_t OwnBagSource::size() const { return impl_->pairs.size(); }

bool OwnBagSource::next(core::ImagePair& pair) {
  if (impl_->position == impl_->pairs.size()) return false;
  impl_->read(impl_->pairs[impl_->position++], pair);
  return true;
}

}  // namespace corrsel
