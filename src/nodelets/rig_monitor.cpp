#include "corrsel/rig_monitor.h"

#include <diagnostic_updater/diagnostic_updater.h>
#include <nodelet/nodelet.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <pluginlib/class_list_macros.hpp>
#include <stdexcept>
#include <string>

#include "base/text.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/rig_state.h"
#include "ros/live/callback_thread.h"
#include "ros/live/nodelet_parameters.h"
#include "ros/live/parameters.h"
#include "ros/live/periodic.h"
#include "ros/live/rig_calibration.h"
#include "ros/live/wall_throttle.h"

namespace corrsel {

/// Watches a calibrated stereo rig: takes the selected `matches`, and publishes once per period what they
/// show of it (`rig_state`, /diagnostics). Writes the corrected calibrations while the rig is found bent.
class RigMonitorNodelet : public nodelet::Nodelet {
 public:
  ~RigMonitorNodelet() override {
    thread_.stop();
    timer_.reset();
  }

 private:
  using Status = diagnostic_updater::DiagnosticStatusWrapper;

  void onInit() override {
    for (const std::string& text : readParameters(getPrivateNodeHandle(), parameters_)) {
      NODELET_ERROR_STREAM(text);
    }
    ros::NodeHandle nh = thread_.handle(getNodeHandle());
    const auto queue = static_cast<std::uint32_t>(parameters_.subscriber_queue_size);
    publisher_ = nh.advertise<RigState>("rig_state", 10, true);
    left_info_ = nh.subscribe<sensor_msgs::CameraInfo>(
        "left/camera_info", 1, [this](const sensor_msgs::CameraInfoConstPtr& msg) { left_ = msg; });
    right_info_ = nh.subscribe<sensor_msgs::CameraInfo>(
        "right/camera_info", 1, [this](const sensor_msgs::CameraInfoConstPtr& msg) { right_ = msg; });
    matches_ = nh.subscribe<Correspondences>("matches", queue,
                                             [this](const CorrespondencesConstPtr& msg) { take(*msg); });
    updater_ = std::make_unique<diagnostic_updater::Updater>(nh, getPrivateNodeHandle(), getName());
    updater_->setHardwareID("none");
    updater_->add("rig", this, &RigMonitorNodelet::diagnose);
    timer_ = std::make_unique<Periodic>(kDiagnosticPeriod, [this] { updater_->force_update(); });
  }

  void take(const Correspondences& msg) {
    try {
      PairInfo info;
      const core::Correspondences matches = fromMsg(msg, &info);
      if (!info.rig) {
        complain("the matches are of no calibrated rig; P of the right camera_info needs a baseline");
        return;
      }
      watch(*info.rig);
      monitor_->add(info.header.stamp.toSec(), matches);
      report(info);
    } catch (const std::exception& error) {  // malformed messages, matches without cameras
      complain(error.what());
    }
  }

  /// Begins anew where the calibration has changed.
  void watch(const RigPose& rig) {
    const bool same = rig_ && rig_->rotation == rig.rotation && rig_->translation == rig.translation;
    if (same) return;
    if (rig_) NODELET_INFO("the calibration of the rig has changed; watching the new one");
    monitor_ = std::make_unique<core::RigMonitor>(parameters_, rig.rotation, rig.translation);
    rig_ = rig;
    reported_.reset();
  }

  void report(const PairInfo& info) {
    const ros::Time& stamp = info.header.stamp;
    const ros::Duration period(parameters_.report_period);
    if (reported_ && stamp >= *reported_ && stamp - *reported_ < period) return;
    reported_ = stamp;
    const core::RigReport report = monitor_->report();
    const auto msg = boost::make_shared<RigState>(toMsg(report, cv::norm(rig_->translation), info));
    const bool is_bent = report.state == core::RigState::kWarning || report.state == core::RigState::kError;
    if (is_bent && !parameters_.output_folder.empty()) save(*msg);
    publisher_.publish(msg);
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!newest_ || newest_->state != msg->state) {
      const std::string text = "rig " + core::toString(report.state) + ": " + report.message;
      if (is_bent) {
        NODELET_WARN_STREAM(text);
      } else {
        NODELET_INFO_STREAM(text);
      }
    }
    newest_ = msg;
    complaint_.clear();
  }

  void save(const RigState& state) {
    if (!left_ || !right_) {
      complain("no calibration is written, as left/camera_info and right/camera_info have not arrived");
      return;
    }
    const RigCalibration calibration = {*left_, *right_};
    const RigPose pose = {cv::Matx33d(state.corrected_rotation.data()),
                          cv::Vec3d(state.corrected_translation.data())};
    writeCalibration(corrected(calibration, areRectified(calibration), pose), parameters_.output_folder);
  }

  /// Whether the rig of the matches is that between the rectified images of the calibration.
  bool areRectified(const RigCalibration& calibration) const {
    for (const bool rectified : {true, false}) {
      const std::optional<RigPose> rig = rigOf(calibration.left, rectified, calibration.right, rectified);
      if (rig && cv::norm(rig->rotation - rig_->rotation) < 1e-9 &&
          cv::norm(rig->translation - rig_->translation) < 1e-9) {
        return rectified;
      }
    }
    throw std::invalid_argument("left/camera_info and right/camera_info are not those of the matches");
  }

  void complain(const std::string& text) {
    if (throttle_.due()) NODELET_WARN_STREAM(text);
    const std::lock_guard<std::mutex> lock(mutex_);
    complaint_ = text;
  }

  void diagnose(Status& status) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!newest_) {
      status.summary(Status::WARN, complaint_.empty() ? "no matches" : complaint_);
      return;
    }
    const RigState& state = *newest_;
    const bool fine = state.state == RigState::STATE_OK;
    status.summary(fine                                   ? Status::OK
                   : state.state == RigState::STATE_ERROR ? Status::ERROR
                                                          : Status::WARN,
                   core::toString(static_cast<core::RigState>(state.state)) + ": " + state.message);
    if (!complaint_.empty()) status.mergeSummary(Status::WARN, complaint_);
    constexpr double kDegrees = 180 / CV_PI;
    const char* const names[] = {"rotation about x", "rotation about y", "rotation about z",
                                 "baseline along a", "baseline along b"};
    for (std::size_t k = 0; k < 5; ++k) {
      const std::string text = core::formatNumber(kDegrees * state.deviation[k]) + " +- " +
                               core::formatNumber(kDegrees * std::sqrt(state.covariance[6 * k]));
      status.add(std::string(names[k]) + " [degrees]",
                 text + (state.observable[k] != 0 ? "" : " (not observable)"));
    }
    status.add("length of the baseline", "not observable");
    status.add("significant angle [degrees]", state.angle);
    status.add("noise [px]", state.noise);
    status.add("pairs", state.n_pairs);
    status.add("matches", state.n_matches);
    for (std::size_t k = 0; k < state.region_median.size(); ++k) {
      status.add("median error of region " + std::to_string(k) + " [px]", state.region_median[k]);
    }
  }

  static constexpr double kDiagnosticPeriod = 1;  // s, wall time

  CallbackThread thread_;  ///< one callback at a time, so that no locks are needed; first: see CallbackThread
  RigMonitorParameters parameters_;
  std::unique_ptr<core::RigMonitor> monitor_;
  std::optional<RigPose> rig_;
  std::optional<ros::Time> reported_;  ///< stamp of the newest report
  sensor_msgs::CameraInfoConstPtr left_, right_;
  WallThrottle throttle_;
  std::mutex mutex_;  ///< guards the next two, which the diagnostics read
  RigStateConstPtr newest_;
  std::string complaint_;
  ros::Publisher publisher_;
  ros::Subscriber left_info_, right_info_, matches_;
  std::unique_ptr<diagnostic_updater::Updater> updater_;
  std::unique_ptr<Periodic> timer_;
};

}  // namespace corrsel

PLUGINLIB_EXPORT_CLASS(corrsel::RigMonitorNodelet, nodelet::Nodelet)
