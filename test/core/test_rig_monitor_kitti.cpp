// RigMonitor on the stereo frames of KITTI in ../shared/data: 37 raw pairs that are repeated at 10 Hz.

#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/rig_monitor.h"
#include "corrsel/selectors/factory.h"
#include "geometry/pose_fit.h"
#include "test_paths.h"

namespace corrsel::core {
namespace {

constexpr double kDegree = CV_PI / 180;

std::vector<double> numbersOf(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<double>(stream), {}};
}

/// The raw pairs with their selected matches.
struct Recording {
  cv::Matx33d rotation;
  cv::Vec3d translation;
  std::vector<Correspondences> pairs;
};

Camera cameraOf(const std::map<std::string, std::vector<double>>& entries, const std::string& number) {
  Camera camera;
  camera.matrix = cv::Matx33d(entries.at("K_" + number).data());
  std::copy_n(entries.at("D_" + number).begin(), 5, camera.distortion.begin());
  camera.size = {static_cast<int>(entries.at("S_" + number)[0]),
                 static_cast<int>(entries.at("S_" + number)[1])};
  return camera;
}

Recording read(const std::string& folder) {
  std::map<std::string, std::vector<double>> entries;
  std::ifstream file(folder + "/calib_cam_to_cam.txt");
  for (std::string line; std::getline(file, line);) {
    const std::size_t colon = line.find(':');
    if (colon != std::string::npos) entries[line.substr(0, colon)] = numbersOf(line.substr(colon + 1));
  }
  Recording recording;
  recording.rotation = cv::Matx33d(entries.at("R_01").data());
  recording.translation = cv::Vec3d(entries.at("T_01").data());
  const auto extractor = createExtractor("sift+sift", {{"sift", {{"max_features", "1000"}}}});
  const auto selector = createSelector("auto");
  for (int i = 0; i < 37; ++i) {
    char name[32];
    std::snprintf(name, sizeof(name), "_%010d.png", i);
    const cv::Mat left = cv::imread(folder + "/left" + name, cv::IMREAD_GRAYSCALE);
    const cv::Mat right = cv::imread(folder + "/right" + name, cv::IMREAD_GRAYSCALE);
    Correspondences matches = matchFeatures(extractor->extract(left), extractor->extract(right));
    matches.left_camera = cameraOf(entries, "00");
    matches.right_camera = cameraOf(entries, "01");
    matches.left_size = left.size();
    matches.right_size = right.size();
    recording.pairs.push_back(matches.subset(selectedRows(selector->select(matches).mask)));
  }
  return recording;
}

/// The matches as they would be if the right camera had turned.
Correspondences turned(Correspondences matches, const cv::Vec3d& degrees) {
  Pose pose;
  pose.translation = {1, 0, 0};
  const cv::Vec3d w = degrees * kDegree;
  pose = moved(pose, {w[0], w[1], w[2], 0, 0});
  for (std::size_t i = 0; i < matches.size(); ++i) {
    Ray ray;
    cv::Point2d pixel;
    if (!unproject(*matches.right_camera, {matches.right_x[i], matches.right_y[i]}, ray)) continue;
    if (!project(*matches.right_camera, pose.rotation * ray.direction, pixel)) continue;
    matches.right_x[i] = static_cast<float>(pixel.x);
    matches.right_y[i] = static_cast<float>(pixel.y);
  }
  return matches;
}

/// Plays pairs at 10 Hz with a report each half second.
class Player {
 public:
  Player(const Recording& recording, double learn) : recording_(recording) {
    RigMonitorOptions options;
    options.learn = learn;
    options.hold = 1.5;  // the 37 frames bring nothing new after 3.6 s
    monitor_ = std::make_unique<RigMonitor>(options, recording.rotation, recording.translation);
  }

  /// @return seconds until the first warning, and until the first significant deviation; NaN = none
  struct Result {
    RigReport last;
    double warning = std::nan(""), significant = std::nan("");
  };
  Result play(double seconds, const cv::Vec3d& degrees = {}) {
    Result result;
    for (int i = 1; i <= std::lround(10 * seconds); ++i) {
      ++count_;
      monitor_->add(0.1 * count_, turned(recording_.pairs[static_cast<std::size_t>(count_) % 37], degrees));
      if (i % 5 != 0) continue;
      result.last = monitor_->report();
      const bool bad = result.last.state == RigState::kWarning || result.last.state == RigState::kError;
      if (bad && std::isnan(result.warning)) result.warning = 0.1 * i;
      if (result.last.angle > 0 && std::isnan(result.significant)) result.significant = 0.1 * i;
    }
    return result;
  }

 private:
  const Recording& recording_;
  std::unique_ptr<RigMonitor> monitor_;
  int count_ = 0;
};

const Recording& recording() {
  static const Recording result = read(corrsel::testing::realDataDir() + "/kitti_stereo");
  return result;
}

bool isThere() {
  return std::ifstream(corrsel::testing::realDataDir() + "/kitti_stereo/calib_cam_to_cam.txt").good();
}

void print(const RigReport& report) {
  std::printf("%s, %zu matches in %zu pairs, noise %.2f px, deviation", toString(report.state).c_str(),
              report.matches, report.pairs, report.noise);
  for (int k = 0; k < 5; ++k) {
    std::printf(" %.3f+-%.3f", report.deviation[k] / kDegree, std::sqrt(report.covariance(k, k)) / kDegree);
  }
  std::printf(" degrees\n");
}

TEST(RigMonitorKitti, TurnsAfterTheStart) {
  if (!isThere()) GTEST_SKIP() << "no kitti_stereo in " << corrsel::testing::realDataDir();
  for (int axis = 0; axis < 3; ++axis) {
    for (const double size : {0.05, 0.1, 0.2, 0.5}) {
      cv::Vec3d degrees;
      degrees[axis] = size;
      Player player(recording(), 5);
      ASSERT_EQ(player.play(8).last.state, RigState::kOk);
      const Player::Result early = player.play(5, degrees);
      const RigReport late = player.play(5, degrees).last;
      const auto error = [&](const RigReport& report) {
        return cv::norm(cv::Vec3d(report.deviation[0], report.deviation[1], report.deviation[2]) / kDegree -
                        degrees);
      };
      std::printf(
          "%c %.2f: significant after %.1f s, warning after %.1f s, error after 5 s %.3f, after 10 s %.3f, "
          "state %s\n",
          "xyz"[axis], size, early.significant, early.warning, error(early.last), error(late),
          toString(late.state).c_str());
      if (axis != 1 && size >= 0.2) {
        EXPECT_LE(early.warning, 5.0) << axis << " " << size;
        EXPECT_LT(error(late), 0.1) << axis << " " << size;
      }
    }
  }
}

TEST(RigMonitorKitti, TheCalibrationAsItIs) {
  if (!isThere()) GTEST_SKIP() << "no kitti_stereo in " << corrsel::testing::realDataDir();
  Player player(recording(), 0);
  const RigReport report = player.play(10).last;
  print(report);
  std::printf("%s\n", report.message.c_str());
  for (const RigRegion& region : report.regions) {
    std::printf("%zu %.2f %.2f %.2f\n", region.count, region.median, region.rms, region.corrected_median);
  }
  EXPECT_TRUE(report.determined);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double size : {0.05, 0.1, 0.2, 0.5}) {
      cv::Vec3d degrees;
      degrees[axis] = size;
      Player bent(recording(), 0);
      const RigReport after = bent.play(10, degrees).last;
      std::printf("%c %.2f: ", "xyz"[axis], size);
      print(after);
    }
  }
}

}  // namespace
}  // namespace corrsel::core
