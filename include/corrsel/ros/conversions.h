#pragma once

#include <cv_bridge/cv_bridge.h>
#include <ros/time.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "corrsel/Correspondences.h"
#include "corrsel/GroundTruth.h"
#include "corrsel/ImageQuality.h"
#include "corrsel/Score.h"
#include "corrsel/Selection.h"
#include "corrsel/StageTimes.h"
#include "corrsel/correspondences.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/features/image_quality.h"
#include "corrsel/ground_truth.h"
#include "corrsel/image_pair.h"
#include "corrsel/ros/cameras.h"
#include "corrsel/selection.h"

namespace corrsel {

/// Times of stages none of which has been measured.
inline StageTimes unmeasured() {
  StageTimes times;
  times.wait = times.detect = times.describe = std::numeric_limits<double>::quiet_NaN();
  times.match = times.select = times.publish = std::numeric_limits<double>::quiet_NaN();
  return times;
}

/// Everything in a Correspondences or Selection message beside the data itself: which images the pair
/// consists of and how its matches were made.
struct PairInfo {
  std_msgs::Header header;                               ///< stamp and frame of the left image
  ros::Time right_stamp;                                 ///< stamp of the right image
  std::string right_frame_id;                            ///< frame of the right image
  core::PairId id;                                       ///< empty in live use
  std::string features;                                  ///< "detector+descriptor" or "given"
  std::optional<RigPose> rig;                            ///< of a calibrated rig
  core::GuessVerdict guess = core::GuessVerdict::kNone;  ///< of the matcher
  core::ImageQuality left_quality, right_quality;
  std::uint32_t n_left_features = 0, n_right_features = 0;
  StageTimes seconds = unmeasured();
};

/// Everything in a Score message beside the evaluation.
struct ScoreLabels {
  PairInfo pair;
  std::string preselection = "none";  ///< "none" or "nnsr"
  std::string selector;               ///< name, with the preset where one was given
  core::Status status = core::Status::kOk;
  double select_seconds = std::numeric_limits<double>::quiet_NaN();
};

/// Converts matches to a message with as many matches. An optional column that is empty stays empty.
Correspondences toMsg(core::Correspondences matches, const PairInfo& info);

/// Converts a message to matches.
/// @param info  filled with everything else in the message where it is not null
/// Throws std::invalid_argument that names the field if array lengths disagree, if a frame does not have six
/// numbers per match, if an image size is larger than any image can be, or if a camera is none. The rig is
/// read with `info` only, and must be a rotation and a translation.
core::Correspondences fromMsg(const Correspondences& msg, PairInfo* info = nullptr);

ImageQuality toMsg(const core::ImageQuality& quality);

core::ImageQuality fromMsg(const ImageQuality& msg);

/// Converts a selection to a message.
/// @param info      pair of the selection; its times are copied, except that of the selection itself
/// @param selector  name, with the preset where one was given, e.g. "lpm:v2"
Selection toMsg(const core::Selection& selection, const PairInfo& info, const std::string& selector);

/// Converts a message to a selection.
/// @param info      header, right stamp, right frame, qualities and times are filled where it is not null
/// @param selector  filled with the selector's name where it is not null
/// Throws std::invalid_argument that names the field if the status or the kind of model is unknown, if the
/// mask contains anything but 0 and 1, if counts or lengths disagree with the mask, or if the model is not
/// finite.
core::Selection fromMsg(const Selection& msg, PairInfo* info = nullptr, std::string* selector = nullptr);

/// Converts ground truth to a message, with the header and the id of `info`. Only the fields that belong to
/// the kind of truth are filled.
GroundTruth toMsg(const core::GroundTruth& truth, const PairInfo& info);

/// Converts a message to ground truth.
/// @param info  header and id are filled where it is not null
/// Throws std::invalid_argument that names the field if the kind is unknown, if a matrix is not finite, if
/// the disparity array does not have width times height elements, or if a pose is given in part or is none
/// (RelativePose::check()).
core::GroundTruth fromMsg(const GroundTruth& msg, PairInfo* info = nullptr);

Score toMsg(const core::Evaluation& evaluation, const ScoreLabels& labels);

/// Converts an image message to 8-bit grey or BGR, as the core expects it. mono8, bgr8, 8UC1 and 8UC3 share
/// the message's data. Other colour, Bayer and YUV encodings are converted, 16-bit values v of either byte
/// order become v / 257, rounded, and four channels without a meaning (8UC4, 16UC4) are taken as BGRA.
/// Throws std::invalid_argument that names the encoding for anything else (floats, other numbers of
/// channels), for an image without pixels, and for data that do not fit the header: a step shorter than a
/// row, or a number of bytes other than step times height.
cv_bridge::CvImageConstPtr fromMsg(const sensor_msgs::ImageConstPtr& image);

/// Converts an image message to an image from which FeatureExtractor::extract() makes the same features as
/// from that of fromMsg(), with less copying: grey, BGR and BGRA of 8 and 16 bits (mono, bgr, bgra, and UC
/// with 1, 3 or 4 channels) share the message's data where it has this machine's byte order. rgb8 and rgba8
/// become grey at once; all others are converted by fromMsg(). Throws what fromMsg() throws.
cv_bridge::CvImageConstPtr fromMsgForFeatures(const sensor_msgs::ImageConstPtr& image);

/// Converts like fromMsg(), but images of 16 bits (mono, bgr, bgra, and UC with 1, 3 or 4 channels) keep
/// their values and share the message's data where it has this machine's byte order.
cv_bridge::CvImageConstPtr fromMsgInAllBits(const sensor_msgs::ImageConstPtr& image);

/// Decodes PNG, JPEG and every other format that OpenCV reads to 8-bit grey or BGR. Throws
/// std::invalid_argument that names the format if the data cannot be decoded or if a JPEG is cut off.
cv::Mat fromMsg(const sensor_msgs::CompressedImage& msg);

/// Decodes like fromMsg(), but images of 16 bits keep their values.
cv::Mat fromMsgInAllBits(const sensor_msgs::CompressedImage& msg);

/// Encodes grey or BGR, 8 or 16 bits, as PNG. cv_bridge before version 1.16 makes 8-bit BGR of every image.
/// Throws cv::Exception where OpenCV cannot encode the image.
sensor_msgs::CompressedImage toPngMsg(const std_msgs::Header& header, const cv::Mat& image);

}  // namespace corrsel
