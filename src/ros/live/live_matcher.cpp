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

/// The features and the calibration of an image.
struct Side {
  const core::Features& features;
  std::optional<core::Camera> camera;
};

/// Matches the features and makes the message.
/// @param conversion_seconds  spent on the images
/// @param kept  filled with the matches where not null
boost::shared_ptr<Correspondences> finish(const Side& left, const Side& right,
                                          const core::MatchOptions& options, int threads,
                                          double conversion_seconds, PairInfo info,
                                          core::Correspondences* kept = nullptr) {
  core::Stopwatch watch;
  core::Correspondences matches = core::matchFeatures(left.features, right.features, options, threads);
  matches.left_camera = left.camera;
  matches.right_camera = right.camera;
  info.seconds.match = watch.restart();
  info.n_left_features = static_cast<std::uint32_t>(left.features.keypoints.size());
  info.n_right_features = static_cast<std::uint32_t>(right.features.keypoints.size());
  if (kept != nullptr) *kept = matches;
  auto message = boost::make_shared<Correspondences>(toMsg(std::move(matches), info));
  message->seconds.publish = conversion_seconds + watch.seconds();
  return message;
}

}  // namespace

boost::shared_ptr<Correspondences> LiveMatcher::match(const ImageSet& images, const Settings& settings) {
  return images.right ? matchPair(images, settings) : matchSequence(images, settings);
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
  return finish({features.first, cameraOf(from)}, {features.second, cameraOf(to)}, settings.match, threads_,
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

  const std::optional<core::Camera> camera = cameraOf(images.left_calibration);
  const std::uint64_t id = info.header.stamp.toNSec();
  sequence_.setOptions(settings.sequence);
  const core::Sequence::Frame* reference = sequence_.reference();
  // Features of another kind or size, or of a time that has not come yet (a bag that starts again).
  if (sequence_extractor_ != settings.extractor ||
      (reference != nullptr &&
       (reference->features->image_size != features->image_size || reference->id > id))) {
    sequence_.reset();
    reference = nullptr;
  }
  sequence_extractor_ = settings.extractor;

  boost::shared_ptr<Correspondences> message;
  core::Correspondences matches;
  if (reference != nullptr) {
    info.right_stamp.fromNSec(reference->id);
    info.right_frame_id = info.header.frame_id;
    message = finish({*features, camera}, {*reference->features, reference->camera}, settings.match, threads_,
                     conversion_seconds, info, &matches);
  }
  sequence_.add({id, std::move(features), camera}, matches);
  return message;
}

std::string camerasText(const Correspondences& message) {
  return "left " + modelText(message.left_camera) + ", right " + modelText(message.right_camera) +
         (std::isnan(message.rig_translation[0]) ? "" : ", a rig");
}

}  // namespace corrsel
