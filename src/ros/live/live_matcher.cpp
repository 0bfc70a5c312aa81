#include "ros/live/live_matcher.h"

#include <algorithm>
#include <boost/make_shared.hpp>
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

core::FeatureRegion region(const cv::Mat& mask, cv::Rect area, const cv::Size& size) {
  core::FeatureRegion result;
  if (area != cv::Rect()) {
    if (area.width == 0) area.width = std::max(1, size.width - area.x);
    if (area.height == 0) area.height = std::max(1, size.height - area.y);
    result.area = area;
  }
  result.mask = mask;
  return result;
}

/// Times and names of a pair whose features are known.
PairInfo infoOf(const ImageSet& images, const LiveMatcher::Settings& settings, double wait_seconds) {
  PairInfo info;
  info.header = images.left->header;
  info.features = settings.flow ? settings.flow->name() : settings.extractor->name();
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
  if (settings.flow) {
    matching.match = [](const FrameFeatures& left, const FrameFeatures& right,
                        const std::optional<core::MotionGuess>&) {
      return core::GuidedMatches{core::matchFlow(left.features, right.features)};
    };
    return matching;
  }
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

core::ImageQuality LiveMatcher::qualityOf(const cv::Mat& image, const core::FeatureRegion& region,
                                          const ros::Time& stamp, const core::Features& features,
                                          core::ImageQualityMeter& meter) const {
  core::ImageQuality quality;
  if (measures_quality_) {
    const cv::Rect whole({0, 0}, image.size());
    quality = meter.measure(image(region.area.empty() ? whole : region.area & whole), stamp.toSec());
  }
  quality.texture = core::textureOf(features);
  return quality;
}

boost::shared_ptr<Correspondences> LiveMatcher::matchPair(const ImageSet& images, const Settings& settings) {
  PairInfo info = infoOf(images, settings, images.waiting.seconds());
  info.right_stamp = images.right->header.stamp;
  info.right_frame_id = images.right->header.frame_id;
  core::Stopwatch watch;
  const cv_bridge::CvImageConstPtr left = fromMsgForFeatures(images.left),
                                   right = fromMsgForFeatures(images.right);
  const cv::Size left_size = left->image.size(), right_size = right->image.size();
  const core::FeatureRegion left_region =
                                region(left_mask_.of(images.left_mask, left_size), settings.area, left_size),
                            right_region = region(right_mask_.of(images.right_mask, right_size),
                                                  settings.area, right_size);
  countBits(left->image);
  countBits(right->image);
  const cv::Mat left_pixels = inUsedBits(left->image), right_pixels = inUsedBits(right->image);
  double conversion_seconds = watch.restart();
  const auto features =
      core::extractPair(*settings.extractor, left_pixels, right_pixels, threads_, left_region, right_region);
  watch.restart();
  info.left_quality = qualityOf(left_pixels, left_region, info.header.stamp, features.first, left_meter_);
  info.right_quality = qualityOf(right_pixels, right_region, info.right_stamp, features.second, right_meter_);
  conversion_seconds += watch.seconds();
  info.seconds.detect = features.first.detect_seconds + features.second.detect_seconds;
  info.seconds.describe = features.first.describe_seconds + features.second.describe_seconds;
  const CalibrationPtr &from = images.left_calibration, &to = images.right_calibration;
  if (from && to) info.rig = rigOf(from->info, from->rectified, to->info, to->rectified);
  return matchFrames({features.first, cameraOf(from)}, {features.second, cameraOf(to)}, matchingOf(settings),
                     conversion_seconds, info);
}

/// Begins a new sequence where the features are of another kind; points are not followed into the past.
void LiveMatcher::followSettings(const Settings& settings, const ros::Time& stamp) {
  if (sequence_extractor_ != settings.extractor || sequence_flow_ != settings.flow) sequence_.reset();
  sequence_extractor_ = settings.extractor;
  sequence_flow_ = settings.flow;
  if (settings.flow && stamp < newest_stamp_) settings.flow->reset();
  newest_stamp_ = stamp;
}

boost::shared_ptr<Correspondences> LiveMatcher::matchSequence(const ImageSet& images,
                                                              const Settings& settings) {
  PairInfo info = infoOf(images, settings, images.waiting.seconds());
  core::Stopwatch watch;
  const cv_bridge::CvImageConstPtr image = fromMsgForFeatures(images.left);
  const cv::Size size = image->image.size();
  const core::FeatureRegion where = region(left_mask_.of(images.left_mask, size), settings.area, size);
  countBits(image->image);
  const cv::Mat pixels = inUsedBits(image->image);
  double conversion_seconds = watch.restart();
  followSettings(settings, images.left->header.stamp);
  auto features =
      std::make_shared<core::Features>(settings.flow ? settings.flow->track(pixels, threads_, where)
                                                     : settings.extractor->extract(pixels, threads_, where));
  watch.restart();
  info.left_quality = qualityOf(pixels, where, info.header.stamp, *features, left_meter_);
  conversion_seconds += watch.seconds();
  info.seconds.detect = features->detect_seconds;
  info.seconds.describe = features->describe_seconds;
  newest_ = features;
  newest_info_ = {info.header, info.features, cameraOf(images.left_calibration),
                  features->detect_seconds + features->describe_seconds};
  return sequence_.add(std::move(features), cameraOf(images.left_calibration), settings.sequence,
                       matchingOf(settings), conversion_seconds, info);
}

boost::shared_ptr<Features> LiveMatcher::newestFeatures() const {
  if (newest_ == nullptr) return nullptr;
  return boost::make_shared<Features>(toMsg(*newest_, newest_info_));
}

std::string camerasText(const Correspondences& message) {
  return "left " + modelText(message.left_camera) + ", right " + modelText(message.right_camera) +
         (std::isnan(message.rig_translation[0]) ? "" : ", a rig");
}

}  // namespace corrsel
