#include "ros/live/rig_calibration.h"

#include <camera_calibration_parsers/parse_yml.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace corrsel {
namespace {

cv::Matx33d rotationOf(const sensor_msgs::CameraInfo& info) { return cv::Matx33d(info.R.data()); }

/// The pose between the cameras themselves.
RigPose rawPose(const RigCalibration& calibration, bool rectified, const RigPose& pose) {
  if (!rectified) return pose;
  const cv::Matx33d back = rotationOf(calibration.right).t();
  return {back * pose.rotation * rotationOf(calibration.left), back * pose.translation};
}

/// The result of OpenCV's functions.
struct Rectification {
  cv::Matx33d rotations[2];
  cv::Matx34d projections[2];
};

Rectification rectify(const RigCalibration& calibration, const RigPose& pose) {
  const core::Camera cameras[] = {cameraOf(calibration.left, false), cameraOf(calibration.right, false)};
  const cv::Size size(static_cast<int>(calibration.left.width), static_cast<int>(calibration.left.height));
  const cv::Mat k[] = {cv::Mat(3, 3, CV_64F, const_cast<double*>(calibration.left.K.data())),
                       cv::Mat(3, 3, CV_64F, const_cast<double*>(calibration.right.K.data()))};
  const cv::Mat d[] = {cv::Mat(calibration.left.D, true), cv::Mat(calibration.right.D, true)};
  const bool fisheye = cameras[0].model == core::Camera::Model::kFisheye;
  if (fisheye != (cameras[1].model == core::Camera::Model::kFisheye)) {
    throw std::invalid_argument("distortion_model of the cameras is '" + calibration.left.distortion_model +
                                "' and '" + calibration.right.distortion_model +
                                "'; a rig is rectified if both or none are fisheye lenses");
  }
  Rectification result;
  cv::Mat r1, r2, p1, p2, q;
  if (fisheye) {
    cv::fisheye::stereoRectify(k[0], d[0], k[1], d[1], size, pose.rotation, pose.translation, r1, r2, p1, p2,
                               q, cv::CALIB_ZERO_DISPARITY, size);
  } else {
    cv::stereoRectify(k[0], d[0], k[1], d[1], size, pose.rotation, pose.translation, r1, r2, p1, p2, q,
                      cv::CALIB_ZERO_DISPARITY, 0);
  }
  return {{r1, r2}, {p1, p2}};
}

}  // namespace

RigCalibration corrected(const RigCalibration& calibration, bool rectified, const RigPose& pose) {
  const Rectification found = rectify(calibration, rawPose(calibration, rectified, pose));
  RigCalibration result = calibration;
  sensor_msgs::CameraInfo* const infos[] = {&result.left, &result.right};
  for (int k = 0; k < 2; ++k) {
    std::copy_n(found.rotations[k].val, infos[k]->R.size(), infos[k]->R.begin());
    std::copy_n(found.projections[k].val, infos[k]->P.size(), infos[k]->P.begin());
  }
  return result;
}

void writeCalibration(const RigCalibration& calibration, const std::string& folder) {
  namespace fs = std::filesystem;
  std::error_code error;
  fs::create_directories(folder, error);  // a failure shows when the files are written
  const auto write = [&](const std::string& name, const sensor_msgs::CameraInfo& info) {
    const fs::path path = fs::path(folder) / (name + ".yaml"),
                   part = fs::path(folder) / (name + ".yaml.part");
    std::ofstream out(part);
    const bool written = camera_calibration_parsers::writeCalibrationYml(out, name, info);
    out.close();
    if (written && out) fs::rename(part, path, error);
    if (!written || !out || error) {
      throw std::runtime_error("cannot write " + path.string() + "; make its folder writable");
    }
  };
  write("left", calibration.left);
  write("right", calibration.right);
}

}  // namespace corrsel
