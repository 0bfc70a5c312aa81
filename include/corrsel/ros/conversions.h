#pragma once

#include <cv_bridge/cv_bridge.h>
#include <ros/time.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>
#include <std_msgs/Header.h>

#include <cstdint>
#include <limits>
#include <opencv2/core/mat.hpp>
#include <string>

#include "corrsel/Correspondences.h"
#include "corrsel/GroundTruth.h"
#include "corrsel/Score.h"
#include "corrsel/Selection.h"
#include "corrsel/correspondences.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/ground_truth.h"
#include "corrsel/image_pair.h"
#include "corrsel/selection.h"

namespace corrsel {

/// What travels in messages beside the data itself: where, when and how a pair was made. Times are NaN where
/// they were not measured.
struct PairInfo {
  std_msgs::Header header;     ///< stamp and frame of the left image
  ros::Time right_stamp;       ///< stamp of the right image
  std::string right_frame_id;  ///< frame of the right image
  core::PairId id;             ///< empty in live use
  std::string features;        ///< "detector+descriptor" or "given"
  std::uint32_t n_left_features = 0, n_right_features = 0;
  double wait_seconds = std::numeric_limits<double>::quiet_NaN();
  double detect_seconds = std::numeric_limits<double>::quiet_NaN();
  double describe_seconds = std::numeric_limits<double>::quiet_NaN();
  double match_seconds = std::numeric_limits<double>::quiet_NaN();
  double publish_seconds = std::numeric_limits<double>::quiet_NaN();
};

/// Everything of a Score message that the evaluation does not know.
struct ScoreLabels {
  PairInfo pair;
  std::string preselection = "none";  ///< "none" or "nnsr"
  std::string selector;               ///< name, with preset as given
  core::Status status = core::Status::kOk;
  double select_seconds = std::numeric_limits<double>::quiet_NaN();
};

/// Core type to message. The message has as many matches as `matches`; optional columns stay optional.
Correspondences toMsg(core::Correspondences matches, const PairInfo& info);

/// Message to core type. Throws std::invalid_argument naming the field that makes no sense: array lengths
/// that disagree, frames that are not six numbers a match, sizes beyond what an image can have.
/// @param info  filled with everything else in the message where not null
core::Correspondences fromMsg(const Correspondences& msg, PairInfo* info = nullptr);

/// @param selector  name, with preset as given, e.g. "lpm:v2"
Selection toMsg(const core::Selection& selection, const PairInfo& info, const std::string& selector);

/// Throws std::invalid_argument naming the field: unknown status or model kind, a mask with anything but 0
/// and 1, counts and lengths that disagree with the mask, a model that is not finite.
/// @param info      header, right stamp and frame and the times are filled where not null
/// @param selector  filled with the selector's name where not null
core::Selection fromMsg(const Selection& msg, PairInfo* info = nullptr, std::string* selector = nullptr);

/// Uses header and id of `info`. Only the fields of the truth's kind are filled.
GroundTruth toMsg(const core::GroundTruth& truth, const PairInfo& info);

/// Throws std::invalid_argument naming the field: unknown kind, a matrix that is not finite, a disparity
/// array that is not width times height.
/// @param info  header and id are filled where not null
core::GroundTruth fromMsg(const GroundTruth& msg, PairInfo* info = nullptr);

Score toMsg(const core::Evaluation& evaluation, const ScoreLabels& labels);

/// An image message as 8-bit grey or BGR, as the core expects it. mono8, bgr8, 8UC1 and 8UC3 are shared, not
/// copied; other colour, Bayer and YUV encodings are converted, 16 bits of either byte order are scaled to 8,
/// four channels without a meaning (8UC4, 16UC4) are taken as BGRA. Throws std::invalid_argument naming the
/// encoding for anything else (floats, odd channel counts), for an image without pixels and for data that
/// does not fit the header: the step at least a row, step times height bytes.
cv_bridge::CvImageConstPtr fromMsg(const sensor_msgs::ImageConstPtr& image);

/// Decodes PNG, JPEG and whatever else OpenCV reads to 8-bit grey or BGR. Throws std::invalid_argument naming
/// the format where that fails, or where a JPEG is cut off.
cv::Mat fromMsg(const sensor_msgs::CompressedImage& msg);

}  // namespace corrsel
