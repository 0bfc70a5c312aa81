#include "corrsel/ros/conversions.h"

#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <boost/endian/conversion.hpp>
#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/text.h"
#include "features/parts/grey_image.h"
#include "features/parts/image_bytes.h"
#include "ros/messages/fields.h"

namespace corrsel {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t kFrameNumbers = std::tuple_size<core::AffineFrame>::value;
constexpr int kEightBits = cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION;

void requireProbabilities(const std::string& message, const std::vector<float>& values, bool may_be_nan) {
  for (const float value : values) {
    if ((value >= 0 && value <= 1) || (may_be_nan && std::isnan(value))) continue;
    refuse(message, "probability",
           "holds " + std::to_string(value) + ", expected 0 to 1" + (may_be_nan ? ", or NaN" : ""));
  }
}

std::vector<float> flatten(const std::vector<core::AffineFrame>& frames) {
  static_assert(sizeof(core::AffineFrame) == kFrameNumbers * sizeof(float), "frames are numbers in a row");
  const auto* const first = reinterpret_cast<const float*>(frames.data());
  return {first, first + frames.size() * kFrameNumbers};
}

std::vector<core::AffineFrame> unflatten(const std::vector<float>& numbers) {
  std::vector<core::AffineFrame> frames(numbers.size() / kFrameNumbers);
  std::copy_n(numbers.begin(), frames.size() * kFrameNumbers, reinterpret_cast<float*>(frames.data()));
  return frames;
}

template <class Array>
void writeNumbers(const double* values, bool defined, Array& numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = defined ? values[i] : kNaN;
}

template <class Array>
void readNumbers(const std::string& message, const std::string& field, const Array& numbers, double* values) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i])) refuse(message, field, "holds a number that is not finite");
    values[i] = numbers[i];
  }
}

template <class Array>
void writeMatrix(const cv::Matx33d& matrix, bool defined, Array& numbers) {
  writeNumbers(matrix.val, defined, numbers);
}

template <class Array>
cv::Matx33d readMatrix(const std::string& message, const std::string& field, const Array& numbers) {
  cv::Matx33d matrix;
  readNumbers(message, field, numbers, matrix.val);
  return matrix;
}

/// Whether anything was set: messages that are filled in by hand hold zeros where nothing was.
template <class Array>
bool isDefined(const Array& numbers) {
  return std::any_of(numbers.begin(), numbers.end(),
                     [](double number) { return !std::isnan(number) && number != 0; });
}

/// Nothing where all numbers are NaN or zero.
std::optional<core::RelativePose> readPose(const std::string& message, const GroundTruth& msg) {
  if (!isDefined(msg.left_camera) && !isDefined(msg.right_camera) && !isDefined(msg.rotation) &&
      !isDefined(msg.translation)) {
    return {};
  }
  core::RelativePose pose;
  pose.left_camera = readMatrix(message, "left_camera", msg.left_camera);
  pose.right_camera = readMatrix(message, "right_camera", msg.right_camera);
  pose.rotation = readMatrix(message, "rotation", msg.rotation);
  readNumbers(message, "translation", msg.translation, pose.translation.val);
  try {
    pose.check();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(message + ": " + error.what());
  }
  return pose;
}

/// Nothing where the rig is not calibrated.
std::optional<RigPose> readRig(const std::string& message, const Correspondences& msg) {
  if (!isDefined(msg.rig_rotation) && !isDefined(msg.rig_translation)) return {};
  RigPose rig;
  rig.rotation = readMatrix(message, "rig_rotation", msg.rig_rotation);
  readNumbers(message, "rig_translation", msg.rig_translation, rig.translation.val);
  if (!isRotation(rig.rotation)) refuse(message, "rig_rotation", "is not a rotation");
  if (!isDefined(msg.rig_translation)) refuse(message, "rig_translation", "is zero");
  return rig;
}

/// Nothing where nothing was believed of the motion.
std::optional<core::MotionGuess> readGuess(const std::string& message, const Correspondences& msg) {
  if (!isDefined(msg.guess_rotation)) return {};
  core::MotionGuess guess;
  guess.rotation = readMatrix(message, "guess_rotation", msg.guess_rotation);
  if (isDefined(msg.guess_translation)) {
    guess.translation.emplace();
    readNumbers(message, "guess_translation", msg.guess_translation, guess.translation->val);
  }
  guess.rotation_sigma = msg.guess_sigma;
  try {
    guess.check();
  } catch (const std::invalid_argument& error) {
    refuse(message, "guess:", error.what());
  }
  return guess;
}

core::GuessVerdict readVerdict(const std::string& message, std::uint8_t verdict) {
  if (verdict > Selection::GUESS_CONTRADICTED) {
    refuse(message, "guess", "is " + std::to_string(verdict) + ", which is unknown");
  }
  return static_cast<core::GuessVerdict>(verdict);
}

bool isSupported(const std::string& encoding) {
  namespace enc = sensor_msgs::image_encodings;
  static const std::set<std::string> kOthers = {enc::MONO8,      enc::MONO16,     enc::TYPE_8UC1,
                                                enc::TYPE_8UC3,  enc::TYPE_8UC4,  enc::TYPE_16UC1,
                                                enc::TYPE_16UC3, enc::TYPE_16UC4, enc::YUV422};
  return enc::isColor(encoding) || enc::isBayer(encoding) || kOthers.count(encoding) != 0;
}

/// Description of an image message, for error texts.
std::string imageText(const sensor_msgs::Image& msg) {
  return "image with encoding '" + msg.encoding + "', " + std::to_string(msg.width) + "x" +
         std::to_string(msg.height) + " px, step " + std::to_string(msg.step) + ", " +
         std::to_string(msg.data.size()) + " bytes";
}

/// Throws unless the data fit the header. cv_bridge checks this too, but in 32 bits, which overflow.
/// @param pixel_size  bytes
void requirePixels(const sensor_msgs::Image& msg, std::size_t pixel_size) {
  const auto refusal = [&msg](const std::string& what) {
    return std::invalid_argument(imageText(msg) + ": " + what);
  };
  if (msg.width == 0 || msg.height == 0) throw refusal("has no pixels");
  if (msg.width > kMaxImageSide || msg.height > kMaxImageSide) throw refusal("is too large");
  if (msg.step < msg.width * pixel_size) {
    throw refusal("a row needs " + std::to_string(msg.width * pixel_size) + " bytes");
  }
  const std::uint64_t expected = static_cast<std::uint64_t>(msg.step) * msg.height;
  if (msg.data.size() != expected) throw refusal("expected " + std::to_string(expected) + " bytes");
}

/// The image in this machine's byte order: the image itself, or a copy with the bytes of every 16-bit number
/// exchanged.
sensor_msgs::ImageConstPtr inNativeOrder(const sensor_msgs::ImageConstPtr& msg, int depth) {
  constexpr bool kNativeIsBig = boost::endian::order::native == boost::endian::order::big;
  if (depth != 16 || (msg->is_bigendian != 0) == kNativeIsBig) return msg;
  const auto swapped = boost::make_shared<sensor_msgs::Image>(*msg);
  swapped->is_bigendian = kNativeIsBig ? 1 : 0;
  for (std::size_t i = 0; i + 1 < swapped->data.size(); i += 2) {
    std::swap(swapped->data[i], swapped->data[i + 1]);
  }
  return swapped;
}

/// The image in this machine's byte order. Throws unless it can be converted.
sensor_msgs::ImageConstPtr checked(const sensor_msgs::ImageConstPtr& image) {
  namespace enc = sensor_msgs::image_encodings;
  if (!isSupported(image->encoding)) {
    throw std::invalid_argument("image encoding '" + image->encoding +
                                "' is not supported; use 8- or 16-bit grey, colour, Bayer or yuv422");
  }
  const int depth = enc::bitDepth(image->encoding);
  requirePixels(*image, static_cast<std::size_t>(enc::numChannels(image->encoding) * depth / 8));
  return inNativeOrder(image, depth);
}

/// @param flags  of cv::imdecode
cv::Mat decoded(const sensor_msgs::CompressedImage& msg, int flags) {
  cv::Mat image;
  if (core::isCutOff(msg.data)) {
    throw std::invalid_argument("compressed image of format '" + msg.format + "', " +
                                std::to_string(msg.data.size()) + " bytes, is cut off");
  }
  if (!msg.data.empty()) {
    try {
      // Orientation tags are ignored: ground truth refers to the pixels as they are stored.
      image = cv::imdecode(msg.data, flags);
    } catch (const cv::Exception& error) {
      throw std::invalid_argument("compressed image of format '" + msg.format + "': " + error.what());
    }
  }
  if (image.empty()) {
    throw std::invalid_argument("compressed image of format '" + msg.format + "', " +
                                std::to_string(msg.data.size()) + " bytes, cannot be decoded");
  }
  return image;
}

const std::string kSelectionName = "Selection";

/// Throws std::invalid_argument that names a field which holds nonsense.
void requireSense(const Selection& msg) {
  if (msg.status > Selection::STATUS_UNCERTAIN) {
    refuse(kSelectionName, "status", "is " + std::to_string(msg.status) + ", which is unknown");
  }
  if (msg.model_kind > Selection::MODEL_ROTATION) {
    refuse(kSelectionName, "model_kind", "is " + std::to_string(msg.model_kind) + ", which is unknown");
  }
  if (msg.scene > Selection::SCENE_SEVERAL_MOTIONS) {
    refuse(kSelectionName, "scene", "is " + std::to_string(msg.scene) + ", which is unknown");
  }
  if (msg.confidence < 0 || std::isinf(msg.confidence)) {
    refuse(kSelectionName, "confidence",
           "is " + core::formatNumber(msg.confidence) + ", expected a number from 0, or NaN");
  }
  if (msg.sigma < 0 || std::isinf(msg.sigma)) {
    refuse(kSelectionName, "sigma",
           "is " + core::formatNumber(msg.sigma) + ", expected a number from 0, or NaN");
  }
  std::size_t n_selected = 0;
  for (const std::uint8_t value : msg.mask) {
    if (value > 1) refuse(kSelectionName, "mask", "holds " + std::to_string(value) + ", expected 0 or 1");
    n_selected += value;
  }
  requireLength(kSelectionName, "score", msg.score.size(), msg.mask.size(), true);
  requireLength(kSelectionName, "group", msg.group.size(), msg.mask.size(), true);
  for (const std::int32_t number : msg.group) {
    if (number < -1)
      refuse(kSelectionName, "group", "holds " + std::to_string(number) + ", expected -1 or more");
  }
  const auto largest = std::max_element(msg.group.begin(), msg.group.end());
  const int n_groups = largest == msg.group.end() ? 0 : *largest + 1;
  requireLength(kSelectionName, "motion", msg.motion.size(), static_cast<std::size_t>(n_groups), true);
  for (const std::uint8_t motion : msg.motion) {
    if (motion > Selection::GROUP_MOVING) {
      refuse(kSelectionName, "motion", "holds " + std::to_string(motion) + ", which is unknown");
    }
  }
  requireLength(kSelectionName, "probability", msg.probability.size(), msg.mask.size(), true);
  requireProbabilities(kSelectionName, msg.probability, false);
  if (msg.n_input != msg.mask.size()) {
    refuse(kSelectionName, "n_input",
           "is " + std::to_string(msg.n_input) + ", the mask has " + std::to_string(msg.mask.size()) +
               " elements");
  }
  if (msg.n_selected != n_selected) {
    refuse(kSelectionName, "n_selected",
           "is " + std::to_string(msg.n_selected) + ", the mask has " + std::to_string(n_selected) + " ones");
  }
}

}  // namespace

Correspondences toMsg(core::Correspondences matches, const PairInfo& info) {
  Correspondences msg;
  msg.header = info.header;
  msg.right_stamp = info.right_stamp;
  msg.right_frame_id = info.right_frame_id;
  msg.dataset = info.id.dataset;
  msg.sequence = info.id.sequence;
  msg.pair = info.id.pair;
  msg.features = info.features;
  msg.left_width = static_cast<std::uint32_t>(matches.left_size.width);
  msg.left_height = static_cast<std::uint32_t>(matches.left_size.height);
  msg.right_width = static_cast<std::uint32_t>(matches.right_size.width);
  msg.right_height = static_cast<std::uint32_t>(matches.right_size.height);
  msg.left_camera = toMsg(matches.left_camera);
  msg.right_camera = toMsg(matches.right_camera);
  const RigPose rig = info.rig.value_or(RigPose());
  writeMatrix(rig.rotation, info.rig.has_value(), msg.rig_rotation);
  writeNumbers(rig.translation.val, info.rig.has_value(), msg.rig_translation);
  const core::MotionGuess guess = matches.guess.value_or(core::MotionGuess());
  const cv::Vec3d direction = guess.translation.value_or(cv::Vec3d());
  writeMatrix(guess.rotation, matches.guess.has_value(), msg.guess_rotation);
  writeNumbers(direction.val, guess.translation.has_value(), msg.guess_translation);
  msg.guess_sigma = matches.guess ? guess.rotation_sigma : kNaN;
  msg.guess = static_cast<std::uint8_t>(info.guess);
  msg.left_quality = toMsg(info.left_quality);
  msg.right_quality = toMsg(info.right_quality);
  msg.left_x = std::move(matches.left_x);
  msg.left_y = std::move(matches.left_y);
  msg.right_x = std::move(matches.right_x);
  msg.right_y = std::move(matches.right_y);
  msg.distance = std::move(matches.distance);
  msg.second_distance = std::move(matches.second_distance);
  msg.probability = std::move(matches.probability);
  msg.left_frame = flatten(matches.left_frame);
  msg.right_frame = flatten(matches.right_frame);
  msg.left_index = std::move(matches.left_index);
  msg.right_index = std::move(matches.right_index);
  msg.n_left_features = info.n_left_features;
  msg.n_right_features = info.n_right_features;
  msg.seconds = info.seconds;
  return msg;
}

core::Correspondences fromMsg(const Correspondences& msg, PairInfo* info) {
  static const std::string kName = "Correspondences";
  const std::size_t n = msg.left_x.size();
  requireLength(kName, "left_y", msg.left_y.size(), n, false);
  requireLength(kName, "right_x", msg.right_x.size(), n, false);
  requireLength(kName, "right_y", msg.right_y.size(), n, false);
  requireLength(kName, "distance", msg.distance.size(), n, true);
  requireLength(kName, "second_distance", msg.second_distance.size(), n, true);
  requireLength(kName, "probability", msg.probability.size(), n, true);
  requireProbabilities(kName, msg.probability, true);
  requireLength(kName, "left_frame", msg.left_frame.size(), n * kFrameNumbers, true);
  requireLength(kName, "right_frame", msg.right_frame.size(), n * kFrameNumbers, true);
  requireLength(kName, "left_index", msg.left_index.size(), n, true);
  requireLength(kName, "right_index", msg.right_index.size(), n, true);

  core::Correspondences matches;
  matches.left_size = imageSize(kName, "left_", msg.left_width, msg.left_height);
  matches.right_size = imageSize(kName, "right_", msg.right_width, msg.right_height);
  matches.left_camera = readCamera(kName, "left_camera", msg.left_camera);
  matches.right_camera = readCamera(kName, "right_camera", msg.right_camera);
  matches.guess = readGuess(kName, msg);
  matches.left_x = msg.left_x;
  matches.left_y = msg.left_y;
  matches.right_x = msg.right_x;
  matches.right_y = msg.right_y;
  matches.distance = msg.distance;
  matches.second_distance = msg.second_distance;
  matches.probability = msg.probability;
  matches.left_frame = unflatten(msg.left_frame);
  matches.right_frame = unflatten(msg.right_frame);
  matches.left_index = msg.left_index;
  matches.right_index = msg.right_index;
  if (info != nullptr) {
    info->header = msg.header;
    info->right_stamp = msg.right_stamp;
    info->right_frame_id = msg.right_frame_id;
    info->id = {msg.dataset, msg.sequence, msg.pair};
    info->features = msg.features;
    info->rig = readRig(kName, msg);
    info->guess = readVerdict(kName, msg.guess);
    info->left_quality = fromMsg(msg.left_quality);
    info->right_quality = fromMsg(msg.right_quality);
    info->n_left_features = msg.n_left_features;
    info->n_right_features = msg.n_right_features;
    info->seconds = msg.seconds;
  }
  return matches;
}

ImageQuality toMsg(const core::ImageQuality& quality) {
  ImageQuality msg;
  msg.black = quality.black;
  msg.saturated = quality.saturated;
  msg.blur = quality.blur;
  msg.relative_blur = quality.relative_blur;
  msg.noise = quality.noise;
  msg.texture = quality.texture;
  return msg;
}

core::ImageQuality fromMsg(const ImageQuality& msg) {
  core::ImageQuality quality;
  quality.black = msg.black;
  quality.saturated = msg.saturated;
  quality.blur = msg.blur;
  quality.relative_blur = msg.relative_blur;
  quality.noise = msg.noise;
  quality.texture = msg.texture;
  return quality;
}

Selection toMsg(const core::Selection& selection, const PairInfo& info, const std::string& selector) {
  Selection msg;
  msg.header = info.header;
  msg.right_stamp = info.right_stamp;
  msg.right_frame_id = info.right_frame_id;
  msg.selector = selector;
  msg.status = static_cast<std::uint8_t>(selection.status);
  msg.scene = static_cast<std::uint8_t>(selection.scene);
  msg.confidence = selection.confidence;
  msg.sigma = selection.sigma;
  msg.message = selection.message;
  msg.mask = selection.mask;
  msg.score = selection.score;
  msg.group = selection.group;
  for (const core::GroupMotion motion : selection.motion) {
    msg.motion.push_back(static_cast<std::uint8_t>(motion));
  }
  msg.guess = static_cast<std::uint8_t>(selection.guess);
  msg.left_quality = toMsg(info.left_quality);
  msg.right_quality = toMsg(info.right_quality);
  msg.probability = selection.probability;
  msg.model_kind = static_cast<std::uint8_t>(selection.model_kind);
  writeMatrix(selection.model, selection.model_kind != core::ModelKind::kNone, msg.model);
  msg.n_input = static_cast<std::uint32_t>(selection.n_input);
  msg.n_ignored = static_cast<std::uint32_t>(selection.n_ignored);
  msg.n_selected = static_cast<std::uint32_t>(selection.n_selected);
  msg.iterations = selection.iterations;
  msg.seconds = info.seconds;
  msg.seconds.select = selection.seconds;
  return msg;
}

core::Selection fromMsg(const Selection& msg, PairInfo* info, std::string* selector) {
  requireSense(msg);
  core::Selection selection;
  selection.mask = msg.mask;
  selection.score = msg.score;
  selection.group = msg.group;
  for (const std::uint8_t motion : msg.motion) {
    selection.motion.push_back(static_cast<core::GroupMotion>(motion));
  }
  selection.guess = readVerdict(kSelectionName, msg.guess);
  selection.probability = msg.probability;
  selection.model_kind = static_cast<core::ModelKind>(msg.model_kind);
  if (selection.model_kind != core::ModelKind::kNone)
    selection.model = readMatrix(kSelectionName, "model", msg.model);
  selection.status = static_cast<core::Status>(msg.status);
  selection.scene = static_cast<core::SceneKind>(msg.scene);
  selection.confidence = msg.confidence;
  selection.sigma = msg.sigma;
  selection.message = msg.message;
  selection.n_input = msg.n_input;
  selection.n_ignored = msg.n_ignored;
  selection.n_selected = msg.n_selected;
  selection.iterations = msg.iterations;
  selection.seconds = msg.seconds.select;
  if (info != nullptr) {
    info->header = msg.header;
    info->right_stamp = msg.right_stamp;
    info->right_frame_id = msg.right_frame_id;
    info->left_quality = fromMsg(msg.left_quality);
    info->right_quality = fromMsg(msg.right_quality);
    info->seconds = msg.seconds;
  }
  if (selector != nullptr) *selector = msg.selector;
  return selection;
}

GroundTruth toMsg(const core::GroundTruth& truth, const PairInfo& info) {
  GroundTruth msg;
  msg.header = info.header;
  msg.dataset = info.id.dataset;
  msg.sequence = info.id.sequence;
  msg.pair = info.id.pair;
  msg.kind = static_cast<std::uint8_t>(truth.kind);
  writeMatrix(truth.matrix,
              truth.kind == core::TruthKind::kHomography || truth.kind == core::TruthKind::kFundamental ||
                  truth.kind == core::TruthKind::kEssential || truth.kind == core::TruthKind::kRotation,
              msg.matrix);
  if (truth.kind == core::TruthKind::kLabels) msg.labels = truth.labels;
  if (truth.kind == core::TruthKind::kDisparity) {
    if (!truth.disparity.empty() && truth.disparity.type() != CV_32FC1) {
      throw std::invalid_argument("ground truth: disparity is not a single-channel float image");
    }
    msg.disparity_width = static_cast<std::uint32_t>(truth.disparity.cols);
    msg.disparity_height = static_cast<std::uint32_t>(truth.disparity.rows);
    msg.disparity.reserve(truth.disparity.total());
    for (int y = 0; y < truth.disparity.rows; ++y) {
      const float* row = truth.disparity.ptr<float>(y);
      msg.disparity.insert(msg.disparity.end(), row, row + truth.disparity.cols);
    }
  }
  const core::RelativePose pose = truth.pose.value_or(core::RelativePose());
  const bool known = truth.pose.has_value();
  writeMatrix(pose.left_camera, known, msg.left_camera);
  writeMatrix(pose.right_camera, known, msg.right_camera);
  writeMatrix(pose.rotation, known, msg.rotation);
  writeNumbers(pose.translation.val, known, msg.translation);
  return msg;
}

core::GroundTruth fromMsg(const GroundTruth& msg, PairInfo* info) {
  static const std::string kName = "GroundTruth";
  if (msg.kind > GroundTruth::KIND_ROTATION) {
    refuse(kName, "kind", "is " + std::to_string(msg.kind) + ", which is unknown");
  }
  core::GroundTruth truth;
  truth.kind = static_cast<core::TruthKind>(msg.kind);
  switch (truth.kind) {
    case core::TruthKind::kNone:
      break;
    case core::TruthKind::kHomography:
    case core::TruthKind::kFundamental:
    case core::TruthKind::kEssential:
    case core::TruthKind::kRotation:
      truth.matrix = readMatrix(kName, "matrix", msg.matrix);
      break;
    case core::TruthKind::kLabels:
      truth.labels = msg.labels;
      break;
    case core::TruthKind::kDisparity: {
      const cv::Size size = imageSize(kName, "disparity", msg.disparity_width, msg.disparity_height);
      const std::size_t total =
          static_cast<std::size_t>(msg.disparity_width) * static_cast<std::size_t>(msg.disparity_height);
      requireLength(kName, "disparity", msg.disparity.size(), total, false);
      truth.disparity.create(size, CV_32FC1);
      if (total > 0) std::memcpy(truth.disparity.data, msg.disparity.data(), total * sizeof(float));
      break;
    }
  }
  truth.pose = readPose(kName, msg);
  if (info != nullptr) {
    info->header = msg.header;
    info->id = {msg.dataset, msg.sequence, msg.pair};
  }
  return truth;
}

Score toMsg(const core::Evaluation& evaluation, const ScoreLabels& labels) {
  Score msg;
  msg.header = labels.pair.header;
  msg.dataset = labels.pair.id.dataset;
  msg.sequence = labels.pair.id.sequence;
  msg.pair = labels.pair.id.pair;
  msg.features = labels.pair.features;
  msg.preselection = labels.preselection;
  msg.selector = labels.selector;
  msg.status = static_cast<std::uint8_t>(labels.status);
  msg.n_putative = static_cast<std::uint32_t>(evaluation.n_putative);
  msg.n_ground_truth = static_cast<std::uint32_t>(evaluation.n_ground_truth);
  msg.n_selected = static_cast<std::uint32_t>(evaluation.n_selected);
  for (const core::Metrics& metrics : evaluation.metrics) {
    msg.tolerance.push_back(metrics.tau);
    msg.n_correct.push_back(static_cast<std::uint32_t>(metrics.n_correct));
    msg.precision.push_back(metrics.precision);
    msg.recall_paper.push_back(metrics.recall_paper);
    msg.recall_same_tau.push_back(metrics.recall_same_tau);
    msg.f_paper.push_back(metrics.f_paper);
    msg.f_same_tau.push_back(metrics.f_same_tau);
  }
  msg.select_seconds = labels.select_seconds;
  return msg;
}

cv_bridge::CvImageConstPtr fromMsg(const sensor_msgs::ImageConstPtr& image) {
  namespace enc = sensor_msgs::image_encodings;
  const sensor_msgs::ImageConstPtr msg = checked(image);
  const std::string& encoding = msg->encoding;
  try {
    if (encoding == enc::MONO8 || encoding == enc::BGR8 || encoding == enc::TYPE_8UC1 ||
        encoding == enc::TYPE_8UC3) {
      return cv_bridge::toCvShare(msg);
    }
    if (encoding == enc::MONO16) return cv_bridge::toCvShare(msg, enc::MONO8);
    if (encoding.find("UC") != std::string::npos) {  // numbers without a meaning: taken as grey, BGR or BGRA
      const cv_bridge::CvImageConstPtr source = cv_bridge::toCvShare(msg);
      const auto converted = boost::make_shared<cv_bridge::CvImage>(
          msg->header, source->image.channels() == 1 ? enc::MONO8 : enc::BGR8);
      converted->image = core::toEightBits(source->image);
      if (source->image.channels() == 4) {
        cv::cvtColor(converted->image, converted->image, cv::COLOR_BGRA2BGR);
      }
      return converted;
    }
    return cv_bridge::toCvShare(msg, enc::BGR8);
  } catch (const std::exception& error) {  // cv_bridge::Exception, cv::Exception
    throw std::invalid_argument(imageText(*msg) + ": " + error.what());
  }
}

cv_bridge::CvImageConstPtr fromMsgForFeatures(const sensor_msgs::ImageConstPtr& image) {
  namespace enc = sensor_msgs::image_encodings;
  static const std::set<std::string> kShared = {
      enc::MONO8,     enc::MONO16,    enc::BGR8,      enc::BGR16,      enc::BGRA8,      enc::BGRA16,
      enc::TYPE_8UC1, enc::TYPE_8UC3, enc::TYPE_8UC4, enc::TYPE_16UC1, enc::TYPE_16UC3, enc::TYPE_16UC4};
  const std::string& encoding = image->encoding;
  const bool to_grey = encoding == enc::RGB8 || encoding == enc::RGBA8;
  if (!to_grey && kShared.count(encoding) == 0) return fromMsg(image);
  const sensor_msgs::ImageConstPtr msg = checked(image);
  try {
    return to_grey ? cv_bridge::toCvShare(msg, enc::MONO8) : cv_bridge::toCvShare(msg);
  } catch (const std::exception& error) {  // cv_bridge::Exception, cv::Exception
    throw std::invalid_argument(imageText(*msg) + ": " + error.what());
  }
}

cv_bridge::CvImageConstPtr fromMsgInAllBits(const sensor_msgs::ImageConstPtr& image) {
  namespace enc = sensor_msgs::image_encodings;
  static const std::set<std::string> kDeep = {enc::MONO16,     enc::BGR16,      enc::BGRA16,
                                              enc::TYPE_16UC1, enc::TYPE_16UC3, enc::TYPE_16UC4};
  return kDeep.count(image->encoding) != 0 ? fromMsgForFeatures(image) : fromMsg(image);
}

cv::Mat fromMsg(const sensor_msgs::CompressedImage& msg) { return decoded(msg, kEightBits); }

cv::Mat fromMsgInAllBits(const sensor_msgs::CompressedImage& msg) {
  cv::Mat image = decoded(msg, kEightBits | cv::IMREAD_ANYDEPTH);
  return image.depth() == CV_8U || image.depth() == CV_16U ? image : fromMsg(msg);
}

sensor_msgs::CompressedImage toPngMsg(const std_msgs::Header& header, const cv::Mat& image) {
  sensor_msgs::CompressedImage msg;
  msg.header = header;
  msg.format = "png";
  cv::imencode(".png", image, msg.data);
  return msg;
}

}  // namespace corrsel
