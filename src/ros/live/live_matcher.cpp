#include "ros/live/live_matcher.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>
#include <utility>

#include "base/stopwatch.h"
#include "corrsel/ros/cameras.h"
#include "corrsel/ros/conversions.h"
#include "features/parts/grey_image.h"

namespace corrsel {
namespace {

core::FeatureRegion region(const sensor_msgs::ImageConstPtr& mask, cv::Rect area, const cv::Size& size) {
  core::FeatureRegion result;
  if (area != cv::Rect()) {
    if (area.width == 0) area.width = std::max(1, size.width - area.x);
    if (area.height == 0) area.height = std::max(1, size.height - area.y);
    result.area = area;
  }
  if (!mask) return result;
  const cv::Mat image = fromMsg(mask)->image;
  if (image.channels() == 1) {
    result.mask = image;
  } else {
    cv::extractChannel(image, result.mask, 0);
  }
  return result;
}

/// Times and names of a pair whose features are known.
PairInfo infoOf(const ImageSet& images, const LiveMatcher::Settings& settings, double wait_seconds) {
  PairInfo info;
  info.header = images.left->header;
  info.features = settings.extractor->name();
  info.seconds.wait = wait_seconds;
  return info;
}

std::optional<core::Camera> cameraOf(const CalibrationPtr& calibration) {
  return calibration ? std::make_optional(calibration->camera) : std::nullopt;
}

std::string modelText(const Camera& camera) {
  if (camera.model == Camera::MODEL_UNKNOWN) return "unknown";
  return core::toString(static_cast<core::Camera::Model>(camera.model - Camera::MODEL_PINHOLE));
}

}  // namespace

boost::shared_ptr<Correspondences> LiveMatcher::match(const ImageSet& images, const Settings& settings) {
  return images.right ? matchPair(images, settings) : matchSequence(images, settings);
}

Matching LiveMatcher::matchingOf(const Settings& settings) {
  Matching matching;
  if (motion_ != nullptr) {
    matching.guess = [this](const FrameFeatures& left, const FrameFeatures& right, const PairInfo& info) {
      std::optional<core::MotionGuess> guess;
      std::string why_missing = "without camera_info of both images, no use can be made of it";
      if (left.camera && right.camera) {
        guess = motion_->between({info.header.stamp, info.header.frame_id},
                                 {info.right_stamp, info.right_frame_id}, why_missing);
      }
      if (!guess) guesses_.missing(why_missing);
      return guess;
    };
  }
  matching.match = [this, &settings](const FrameFeatures& left, const FrameFeatures& right,
                                     const std::optional<core::MotionGuess>& guess) {
    if (!guess) {
      return core::GuidedMatches{
          core::matchFeatures(left.features, right.features, settings.match, threads_)};
    }
    core::GuidedMatches result = core::matchGuided(left.features, right.features, *left.camera, *right.camera,
                                                   *guess, settings.match, settings.guided, threads_);
    guesses_.used(result.verdict);
    return result;
  };
  return matching;
}

void LiveMatcher::countBits(const cv::Mat& image) {
  if (image.depth() != CV_16U || bits_ == core::kMaxBits) return;
  bits_ = std::max(bits_, core::significantBits(core::largestValue(image)));
}

/// Images that use all bits are scaled by the extractor, without a copy of the image.
cv::Mat LiveMatcher::inUsedBits(const cv::Mat& image) const {
  return bits_ < core::kMaxBits ? core::toEightBits(image, bits_) : image;
}

boost::shared_ptr<Correspondences> LiveMatcher::matchPair(const ImageSet& images, const Settings& settings) {
  PairInfo info = infoOf(images, settings, images.waiting.seconds());
  info.right_stamp = images.right->header.stamp;
  info.right_frame_id = images.right->header.frame_id;
  const core::Stopwatch watch;
  const cv_bridge::CvImageConstPtr left = fromMsgForFeatures(images.left),
                                   right = fromMsgForFeatures(images.right);
  const core::FeatureRegion left_region = region(images.left_mask, settings.area, left->image.size()),
                            right_region = region(images.right_mask, settings.area, right->image.size());
  countBits(left->image);
  countBits(right->image);
  const cv::Mat left_pixels = inUsedBits(left->image), right_pixels = inUsedBits(right->image);
  const double conversion_seconds = watch.seconds();
  const auto features =
      core::extractPair(*settings.extractor, left_pixels, right_pixels, threads_, left_region, right_region);
  info.seconds.detect = features.first.detect_seconds + features.second.detect_seconds;
  info.seconds.describe = features.first.describe_seconds + features.second.describe_seconds;
  const CalibrationPtr &from = images.left_calibration, &to = images.right_calibration;
  if (from && to) info.rig = rigOf(from->info, from->rectified, to->info, to->rectified);
  return matchFrames({features.first, cameraOf(from)}, {features.second, cameraOf(to)}, matchingOf(settings),
                     conversion_seconds, info);
}

boost::shared_ptr<Correspondences> LiveMatcher::matchSequence(const ImageSet& images,
                                                              const Settings& settings) {
  PairInfo info = infoOf(images, settings, images.waiting.seconds());
  const core::Stopwatch watch;
  const cv_bridge::CvImageConstPtr image = fromMsgForFeatures(images.left);
  const core::FeatureRegion where = region(images.left_mask, settings.area, image->image.size());
  countBits(image->image);
  const cv::Mat pixels = inUsedBits(image->image);
  const double conversion_seconds = watch.seconds();
  auto features = std::make_shared<core::Features>(settings.extractor->extract(pixels, threads_, where));
  info.seconds.detect = features->detect_seconds;
  info.seconds.describe = features->describe_seconds;
  if (sequence_extractor_ != settings.extractor) sequence_.reset();  // features of another kind
  sequence_extractor_ = settings.extractor;
  return sequence_.add(std::move(features), cameraOf(images.left_calibration), settings.sequence,
                       matchingOf(settings), conversion_seconds, info);
}

std::string camerasText(const Correspondences& message) {
  return "left " + modelText(message.left_camera) + ", right " + modelText(message.right_camera) +
         (std::isnan(message.rig_translation[0]) ? "" : ", a rig");
}

}  // namespace corrsel
