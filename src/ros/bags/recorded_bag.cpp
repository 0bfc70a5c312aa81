#include "ros/bags/recorded_bag.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "base/size_text.h"
#include "base/text.h"
#include "corrsel/camera_formats.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/ros/conversions.h"
#include "ros/bags/bag_scan.h"
#include "ros/bags/rig_truth.h"
#include "ros/bags/stereo_rig.h"

namespace corrsel {
namespace {

/// The beginning of a Correspondences message: the images that the matches belong to.
struct PairHeader {
  std_msgs::Header header;
  ros::Time right_stamp;
  std::string right_frame_id;
};

}  // namespace
}  // namespace corrsel

namespace ros::message_traits {
template <>
struct MD5Sum<corrsel::PairHeader> {
  static const char* value() { return MD5Sum<corrsel::Correspondences>::value(); }
};
}  // namespace ros::message_traits

namespace ros::serialization {
template <>
struct Serializer<corrsel::PairHeader> {
  template <typename Stream>
  static void read(Stream& stream, corrsel::PairHeader& message) {
    stream.next(message.header);
    stream.next(message.right_stamp);
    stream.next(message.right_frame_id);
  }
};
}  // namespace ros::serialization

namespace corrsel {
namespace {

constexpr char kMatchesType[] = "corrsel/Correspondences";
constexpr char kPutativeName[] = "correspondences";
// Raw and rectified images are distinguished by the share of matches, in this many messages, near their
// lines.
constexpr std::size_t kProbes = 20;
constexpr double kProbeTolerance = 2.0;  // px

std::string lastPart(const std::string& topic) { return topic.substr(topic.rfind('/') + 1); }

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// The only element for which the predicate holds; null where there is none or more than one.
template <class Range, class Predicate>
auto only(Range& range, const Predicate& predicate) -> decltype(&*range.begin()) {
  const auto found = std::find_if(range.begin(), range.end(), predicate);
  if (found == range.end() || std::find_if(std::next(found), range.end(), predicate) != range.end()) {
    return nullptr;
  }
  return &*found;
}

/// Frames follow their points: A becomes J A, the position J's third column.
void moveFrame(core::AffineFrame& frame, const cv::Matx23d& map) {
  const cv::Matx22d a(frame[0], frame[1], frame[3], frame[4]);
  const cv::Matx22d moved = map.get_minor<2, 2>(0, 0) * a;
  frame = {static_cast<float>(moved(0, 0)), static_cast<float>(moved(0, 1)), static_cast<float>(map(0, 2)),
           static_cast<float>(moved(1, 0)), static_cast<float>(moved(1, 1)), static_cast<float>(map(1, 2))};
}

void moveSide(const std::vector<cv::Matx23d>& maps, std::vector<float>& x, std::vector<float>& y,
              std::vector<core::AffineFrame>& frames) {
  for (std::size_t i = 0; i < maps.size(); ++i) {
    x[i] = static_cast<float>(maps[i](0, 2));
    y[i] = static_cast<float>(maps[i](1, 2));
    if (!frames.empty()) moveFrame(frames[i], maps[i]);
  }
}

void requireSize(const cv::Size& images, const cv::Size& calibrated, const std::string& info_topic) {
  if (images.empty() || images == calibrated) return;
  throw std::invalid_argument("the matches are of images of " + core::sizeText(images) +
                              " px, camera_info on " + info_topic + " is for " + core::sizeText(calibrated) +
                              " px; record the camera_info that belongs to the images");
}

core::Camera pinhole(const cv::Matx33d& matrix, const cv::Size& size) {
  core::Camera camera;
  camera.matrix = matrix;
  camera.size = size;
  return camera;
}

/// Moves matches of a rig's images to its rectified images; those that are not in both of them are left out.
core::Correspondences rectified(const StereoRig& rig, core::Correspondences matches) {
  const std::vector<cv::Matx23d> left = rig.rectifyLeft(pointsOf(matches.left_x, matches.left_y));
  const std::vector<cv::Matx23d> right = rig.rectifyRight(pointsOf(matches.right_x, matches.right_y));
  std::vector<std::uint32_t> kept;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    if (!std::isnan(left[i](0, 0)) && !std::isnan(right[i](0, 0)))
      kept.push_back(static_cast<std::uint32_t>(i));
  }
  moveSide(left, matches.left_x, matches.left_y, matches.left_frame);
  moveSide(right, matches.right_x, matches.right_y, matches.right_frame);
  matches.left_size = rig.leftArea().size();
  matches.right_size = rig.rightArea().size();
  matches.left_camera = pinhole(rig.pose().left_camera, matches.left_size);
  matches.right_camera = pinhole(rig.pose().right_camera, matches.right_size);
  return kept.size() == matches.size() ? matches : matches.subset(kept);
}

}  // namespace

struct RecordedMatchesSource::Impl {
  struct Pair {
    Stamped matches;
    std::optional<Stamped> truth;
    bool by_rig;
  };

  BagFile file;
  BagTopics options;
  std::vector<std::string>& notes;
  std::string topic, truth_topic;  ///< of the matches; of the truth, empty: none
  std::vector<Stamped> matches, truths;
  std::string left_frame, right_frame;  ///< of the first matches
  std::vector<Calibration> calibrations;
  Calibration left, right;
  std::optional<RawRig> raw_rig;  ///< in place of `rig`, of matches in raw images of fisheye lenses
  std::shared_ptr<const StereoRig> rig;
  std::vector<core::OtherReading> other_declarations;  ///< of the rig's images
  std::string rig_problem;                             ///< why there is no rig
  std::vector<Pair> pairs;
  std::string by_calibration;  ///< text on the pairs that are evaluated with the rig
  std::size_t position = 0;

  Impl(BagFile bag, const BagTopics& topics, std::vector<std::string>& all_notes);
  void findTopics();
  void scan();
  void findCameras();
  const Calibration* findCamera(const std::string& named, const std::string& side, const std::string& other,
                                const std::string& frame) const;
  void makeRig();
  std::array<RigCamera, 2> cameras(bool are_rectified) const;
  std::shared_ptr<const StereoRig> makeRig(bool is_rectified);
  double shareNearLines(const StereoRig& candidate) const;
  bool simultaneous(const Stamped& message) const;
  void makePairs();
  void evaluateByRig(core::Correspondences& matches, core::ImagePair& pair) const;
  core::Correspondences read(const Stamped& message, core::ImagePair& pair) const;
  core::Correspondences read(const Stamped& message) const {
    core::ImagePair ignored;
    return read(message, ignored);
  }
};

void RecordedMatchesSource::Impl::findTopics() {
  const std::vector<std::string> found = file.topicsOfType(kMatchesType);
  if (!options.correspondences.empty()) {
    topic = file.find(options.correspondences, kMatchesType);
    if (topic.empty()) {
      throw core::DatasetError("bag " + file.path() + " has no " + kMatchesType + " on " +
                               options.correspondences + "; it has " + file.describeTopics());
    }
  } else if (found.size() == 1) {
    topic = found.front();
  } else {
    const auto is_putative = [](const std::string& name) { return lastPart(name) == kPutativeName; };
    const std::string* const putative = only(found, is_putative);
    if (putative == nullptr) {
      throw core::DatasetError("bag " + file.path() + " has matches on " + core::joinList(found, ", ") +
                               ": name the topic to use by correspondences");
    }
    topic = *putative;
  }
  notes.push_back("the matches are those on " + topic);
  truth_topic = truthTopic(file, options.ground_truth, notes);
}

void RecordedMatchesSource::Impl::scan() {
  std::vector<BagScan::Topic> topics = {{topic, ros::message_traits::MD5Sum<Correspondences>::value()}};
  if (!truth_topic.empty()) topics.push_back({truth_topic});
  const std::vector<std::string> infos = file.topicsOfType(kInfoType);
  BagScan scan(file, topics, infos);
  matches = scan.take(topic);
  truths = scan.take(truth_topic);
  for (const std::string& info : infos) calibrations.push_back(scan.calibration(info));
  scan.describe(notes);
  if (matches.empty()) {
    const std::size_t unreadable = scan.unreadable(topic);
    throw core::DatasetError(
        "bag " + file.path() + " has no message on " + topic + " that can be read" +
        (unreadable > 0 ? ": " + count(unreadable, "message") + " of another version of " + kMatchesType +
                              ", or damaged; convert a bag of version 0.1.0 by rosbag fix (docs/own_bag.md), "
                              "read the bag with the version of corrsel that recorded it, or record the "
                              "matches again"
                        : ""));
  }
  const auto first = matches.front().message.instantiate<PairHeader>();
  left_frame = first->header.frame_id;
  right_frame = first->right_frame_id;
}

/// Null where it is not clear. @param other  what is in the name of the other camera's topic
const Calibration* RecordedMatchesSource::Impl::findCamera(const std::string& named, const std::string& side,
                                                           const std::string& other,
                                                           const std::string& frame) const {
  if (!named.empty()) {
    const std::string found = namedInfoTopic(file, named, side);
    return only(calibrations, [&](const Calibration& entry) { return entry.topic == found; });
  }
  const Calibration* const by_name = only(calibrations, [&](const Calibration& entry) {
    return contains(entry.topic, side) && !contains(entry.topic, other);
  });
  if (by_name != nullptr || left_frame == right_frame) return by_name;
  return only(calibrations,
              [&](const Calibration& entry) { return entry.info && entry.info->header.frame_id == frame; });
}

void RecordedMatchesSource::Impl::findCameras() {
  const Calibration* const found_left = findCamera(options.left_info, "left", "right", left_frame);
  const Calibration* const found_right = findCamera(options.right_info, "right", "left", right_frame);
  if (calibrations.empty()) {
    rig_problem = "there is no camera_info";
  } else if (found_left == nullptr || found_right == nullptr || found_left == found_right) {
    std::vector<std::string> topics;
    for (const Calibration& calibration : calibrations) topics.push_back(calibration.topic);
    rig_problem = "it is not clear which camera_info is of the left and which of the right camera (" +
                  core::joinList(topics, ", ") + "): name them by left_info and right_info";
  } else {
    left = *found_left;
    right = *found_right;
  }
}

std::array<RigCamera, 2> RecordedMatchesSource::Impl::cameras(bool are_rectified) const {
  return {RigCamera{*left.info, are_rectified, left.topic},
          RigCamera{*right.info, are_rectified, right.topic}};
}

std::shared_ptr<const StereoRig> RecordedMatchesSource::Impl::makeRig(bool is_rectified) {
  try {
    const auto [left_camera, right_camera] = cameras(is_rectified);
    return std::make_shared<const StereoRig>(left_camera, right_camera);
  } catch (const std::invalid_argument& error) {
    rig_problem = error.what();
    return nullptr;
  }
}

/// Share of matches near their epipolar lines, in some messages that are spread over the bag.
double RecordedMatchesSource::Impl::shareNearLines(const StereoRig& candidate) const {
  std::size_t near = 0, all = 0;
  const std::size_t probes = std::min(kProbes, matches.size());
  for (std::size_t k = 0; k < probes; ++k) {
    const Stamped& message = matches[k * matches.size() / probes];
    try {
      const core::Correspondences seen = rectified(candidate, read(message));
      for (const double error : core::groundTruthErrors(truthOf(candidate), seen)) {
        ++all;
        near += error <= kProbeTolerance ? 1 : 0;
      }
    } catch (const std::exception&) {  // next() reports it
    }
  }
  return all == 0 ? 0.0 : static_cast<double>(near) / static_cast<double>(all);
}

void RecordedMatchesSource::Impl::makeRig() {
  if (!rig_problem.empty()) return;
  for (const Calibration* camera : {&left, &right}) {
    describeChanges(*camera, notes);
    if (!camera->info) rig_problem = "no message on " + camera->topic + " can be read";
  }
  if (!rig_problem.empty()) return;
  bool are_rectified = options.images == "rectified";
  if (options.images != "auto") {
    rig = makeRig(are_rectified);
    if (rig) {
      const auto [left_camera, right_camera] = cameras(are_rectified);
      other_declarations = otherDeclarations(left_camera, right_camera, rig);
    }
  } else {
    rig = makeRig(false);
    const std::shared_ptr<const StereoRig> other = makeRig(true);
    if (rig && other) {
      const double raw = shareNearLines(*rig), is_rectified = shareNearLines(*other);
      const bool take_raw = raw > is_rectified;
      const auto percent = [](double share) { return std::to_string(std::lround(100 * share)) + " %"; };
      notes.push_back(std::string("the matches are taken to be of ") + (take_raw ? "raw" : "rectified") +
                      " images: " + percent(std::max(raw, is_rectified)) + " of them are within " +
                      core::formatNumber(kProbeTolerance) + " px of their epipolar lines, " +
                      percent(std::min(raw, is_rectified)) +
                      " otherwise; images:=raw and images:=rectified "
                      "decide it");
      are_rectified = !take_raw;
    } else {
      are_rectified = other != nullptr;
    }
    if (are_rectified) rig = other;
  }
  if (!rig) return;
  rig_problem.clear();
  const auto [left_camera, right_camera] = cameras(are_rectified);
  raw_rig = rawRigOf(left_camera, right_camera);
  if (raw_rig) other_declarations.clear();
  // The first matches show whether camera_info belongs to their images.
  try {
    const core::Correspondences first = read(matches.front());
    requireSize(first.left_size, rig->leftSize(), left.topic);
    requireSize(first.right_size, rig->rightSize(), right.topic);
  } catch (const std::invalid_argument& error) {
    rig.reset();
    rig_problem = error.what();
  }
}

bool RecordedMatchesSource::Impl::simultaneous(const Stamped& message) const {
  const auto header = message.message.instantiate<PairHeader>();
  const double difference = (header->right_stamp - header->header.stamp).toSec();
  return std::abs(difference) <= options.max_stamp_difference;
}

void RecordedMatchesSource::Impl::makePairs() {
  const Partners evaluated = partners(stampsOf(matches), stampsOf(truths), tolerance(options));
  std::size_t by_rig = 0, apart = 0;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    pairs.push_back({matches[i], std::nullopt, false});
    if (evaluated.of[i]) {
      pairs.back().truth.emplace(truths[*evaluated.of[i]]);
    } else if (rig && simultaneous(matches[i])) {
      pairs.back().by_rig = true;
      ++by_rig;
    } else if (rig) {
      ++apart;
    }
  }
  if (evaluated.size() > 0) {
    notes.push_back(std::to_string(evaluated.size()) + " of " + count(pairs.size(), "pair") +
                    " are evaluated with " + truth_topic);
  }
  by_calibration = calibrationText(by_rig, pairs.size(), left, right);
  if (evaluated.size() + by_rig == pairs.size()) return;
  notes.push_back(
      std::to_string(pairs.size() - evaluated.size() - by_rig) + " of " + count(pairs.size(), "pair") +
      " are not evaluated: numbers of matches and times are given, but no precision and no recall, "
      "since there is no truth for their stamps and " +
      (apart > 0 ? "their images were not taken at the same time (within " +
                       core::formatNumber(options.max_stamp_difference) + " s)"
                 : rig_problem));
}

/// Gives a pair cameras and truth of the rig, and moves its matches to rectified images.
void RecordedMatchesSource::Impl::evaluateByRig(core::Correspondences& matches, core::ImagePair& pair) const {
  if (raw_rig) {
    pair.left_camera = raw_rig->left;
    pair.right_camera = raw_rig->right;
    pair.truth = raw_rig->truth;
  } else {
    matches = rectified(*rig, std::move(matches));
    pair.left_camera = core::cameraFromOpenCv(rig->pose().left_camera, {}, matches.left_size);
    pair.right_camera = core::cameraFromOpenCv(rig->pose().right_camera, {}, matches.right_size);
    pair.truth = truthOf(*rig);
    pair.other_readings = other_declarations;
  }
  pair.addCamerasTo(matches);
}

/// Fills in the names of the pair and of its images. Throws std::invalid_argument, or an exception of rosbag.
core::Correspondences RecordedMatchesSource::Impl::read(const Stamped& message, core::ImagePair& pair) const {
  const auto msg = message.message.instantiate<Correspondences>();
  PairInfo info;
  core::Correspondences result = fromMsg(*msg, &info);
  pair.id = info.id.pair.empty() ? file.idAt(message.stamp) : info.id;
  pair.left_name = imageName(info.header.frame_id);
  pair.right_name = imageName(info.right_frame_id);
  return result;
}

RecordedMatchesSource::Impl::Impl(BagFile bag, const BagTopics& topics, std::vector<std::string>& all_notes)
    : file(std::move(bag)), options(topics), notes(all_notes) {
  options.check();
  findTopics();
  scan();
  findCameras();
  makeRig();
  makePairs();
}

RecordedMatchesSource::RecordedMatchesSource(BagFile file, const BagTopics& topics)
    : impl_(std::make_unique<Impl>(std::move(file), topics, notes_)) {
  evaluated_by_calibration_ = impl_->by_calibration;
}

RecordedMatchesSource::~RecordedMatchesSource() = default;

bool RecordedMatchesSource::recognises(const BagFile& file) {
  return !file.topicsOfType(kMatchesType).empty() && file.topicsOfType("sensor_msgs/Image").empty() &&
         file.topicsOfType("sensor_msgs/CompressedImage").empty();
}

std::size_t RecordedMatchesSource::size() const { return impl_->pairs.size(); }

bool RecordedMatchesSource::next(core::ImagePair& pair) {
  if (impl_->position == impl_->pairs.size()) return false;
  const Impl::Pair& from = impl_->pairs[impl_->position++];
  pair = {};
  pair.id = impl_->file.idAt(from.matches.stamp);
  const std::string* topic = &impl_->topic;
  try {
    core::Correspondences matches = impl_->read(from.matches, pair);
    if (from.truth) {
      topic = &impl_->truth_topic;
      pair.truth = readTruth(from.truth->message);
    } else if (from.by_rig) {
      requireSize(matches.left_size, impl_->rig->leftSize(), impl_->left.topic);
      requireSize(matches.right_size, impl_->rig->rightSize(), impl_->right.topic);
      impl_->evaluateByRig(matches, pair);
    }
    pair.given = std::move(matches);
  } catch (const std::exception& error) {  // also a damaged chunk
    throw core::DatasetError(pair.id.text() + ": " + *topic + ": " + error.what());
  }
  return true;
}

}  // namespace corrsel
