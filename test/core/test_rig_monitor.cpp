#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "corrsel/evaluation/pose.h"
#include "corrsel/rig_monitor.h"
#include "rig_scene.h"

namespace corrsel::core {
namespace {

using namespace rig_scene;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

RigMonitor monitorOf(const RigMonitorOptions& options = {}) {
  return {options, calibrated().rotation, calibrated().translation * kBaseline};
}

/// The angle of the rotation between two poses, degrees.
double angleOfRotation(const Pose& a, const Pose& b) {
  return poseErrors(a.rotation, {}, {cv::Matx33d::eye(), cv::Matx33d::eye(), b.rotation, {}}).rotation;
}

/// Drives for some seconds, with a report each second.
RigReport drive(Drive& scene, const Pose& rig, double seconds, RigMonitor& monitor) {
  RigReport report;
  const int pairs = static_cast<int>(std::lround(10 * seconds));
  for (int i = 1; i <= pairs; ++i) {
    const Correspondences matches = scene.next(rig);
    monitor.add(scene.time(), matches);
    if (i % 10 == 0) report = monitor.report();
  }
  return report;
}

/// e^T C^-1 e of the estimated deviation.
double normalizedErrorOf(const RigReport& report, const cv::Vec<double, 5>& degrees) {
  const cv::Vec<double, 5> error = report.deviation - degrees * kDegree;
  return error.dot(report.covariance.inv(cv::DECOMP_CHOLESKY) * error);
}

/// Mean of the normalised errors over many drives with random deviations.
double meanNormalizedError(DriveSpec spec, int drives) {
  double sum = 0;
  Random random(3);
  for (int i = 0; i < drives; ++i) {
    cv::Vec<double, 5> degrees;
    for (int k = 0; k < 5; ++k) degrees[k] = random.uniform(-0.5, 0.5);
    spec.seed = static_cast<std::uint64_t>(i + 1);
    Drive scene(spec);
    RigMonitor monitor = monitorOf();
    sum += normalizedErrorOf(drive(scene, bent(degrees), 5, monitor), degrees);
  }
  return sum / drives;
}

DriveSpec independent() {
  DriveSpec spec;
  spec.own_noise = 0;
  return spec;
}

TEST(RigMonitor, CovarianceIsTrue) {
  // 60 drives: the mean of 5 has a standard error of 0.41.
  const double mean = meanNormalizedError(independent(), 60);
  std::printf("NEES, independent noise: %.2f\n", mean);
  EXPECT_GT(mean, 3.5);
  EXPECT_LT(mean, 6.5);
}

TEST(RigMonitor, CovarianceIsTrueWithNoiseThatPairsHaveInCommon) {
  // Vibration of 0.02 degrees is 20 times the standard deviation of features alone.
  DriveSpec spec = independent();
  spec.common_noise = 0.02;
  const double mean = meanNormalizedError(spec, 60);
  std::printf("NEES, vibration: %.2f\n", mean);
  EXPECT_GT(mean, 3.5);
  EXPECT_LT(mean, 7.5);
}

TEST(RigMonitor, FindsATurnAboutEachAxis) {
  for (int k = 0; k < 3; ++k) {
    for (const double size : {-0.4, 0.4}) {
      cv::Vec<double, 5> degrees;
      degrees[k] = size;
      Drive scene({});
      RigMonitor monitor = monitorOf();
      const RigReport report = drive(scene, bent(degrees), 6, monitor);
      EXPECT_TRUE(report.determined);
      EXPECT_LT(report.noise, 0.5);
      EXPECT_EQ(report.state, RigState::kError) << report.message;
      EXPECT_LT(angleOfRotation(report.corrected, bent(degrees)), 0.03) << k;
    }
  }
}

TEST(RigMonitor, MeasuresATurnOfEachParameter) {
  for (int k = 0; k < 5; ++k) {
    for (const double size : {-0.4, 0.4}) {
      cv::Vec<double, 5> degrees;
      degrees[k] = size;
      // The covariance does not know of noise that a point keeps as long as it is seen.
      Drive scene(independent());
      RigMonitor monitor = monitorOf();
      const RigReport report = drive(scene, bent(degrees), 6, monitor);
      EXPECT_TRUE(report.determined);
      EXPECT_NEAR(report.deviation[k], size * kDegree, 5 * std::sqrt(report.covariance(k, k))) << k;
    }
  }
}

TEST(RigMonitor, IsOkWhereNothingHasTurned) {
  Drive scene({});
  RigMonitor monitor = monitorOf();
  const RigReport report = drive(scene, calibrated(), 6, monitor);
  EXPECT_EQ(report.state, RigState::kOk) << report.message;
  EXPECT_LT(report.angle, 0.05);
  EXPECT_EQ(report.pairs, 51u);
  ASSERT_EQ(report.regions.size(), 9u);
  for (const RigRegion& region : report.regions) {
    EXPECT_GT(region.count, 100u);
    EXPECT_LT(std::abs(region.median), 0.1);
  }
}

TEST(RigMonitor, TellsWhatCannotBeObserved) {
  Drive scene({});
  RigMonitor monitor = monitorOf();
  const RigReport report = drive(scene, calibrated(), 6, monitor);
  EXPECT_TRUE(report.observable[0]);
  EXPECT_TRUE(report.observable[2]);
  EXPECT_GT(report.covariance(1, 1), 20 * report.covariance(0, 0));  // about the vertical axis
  EXPECT_FALSE(report.observable[3]);                                // the baseline, turned towards the scene
  EXPECT_NE(report.message.find("the length of the baseline cannot be observed"), std::string::npos);
  EXPECT_NE(report.message.find("the first direction of the baseline"), std::string::npos);
}

TEST(RigMonitor, SignedErrorsOfRegions) {
  // A right camera that pitches down by 0.1 degrees sees points 1.2 px higher.
  Drive scene({});
  RigMonitor monitor = monitorOf();
  const RigReport report = drive(scene, bent({0.1, 0, 0, 0, 0}), 6, monitor);
  const double expected = 700 * 0.1 * kDegree / std::sqrt(2.0);  // of two noisy points
  for (const RigRegion& region : report.regions) {
    EXPECT_NEAR(std::abs(region.median), expected, 0.25);
    EXPECT_GT(region.median * report.regions[4].median, 0);
    EXPECT_NEAR(region.corrected_median, 0, 0.1);
    EXPECT_GE(region.rms, 0.5);
  }
}

TEST(RigMonitor, StateRisesAndFallsWithDelay) {
  Drive scene({});
  RigMonitor monitor = monitorOf();
  EXPECT_EQ(drive(scene, calibrated(), 10, monitor).state, RigState::kOk);
  EXPECT_EQ(drive(scene, bent({0, 0, 0.5, 0, 0}), 1, monitor).state, RigState::kOk);
  EXPECT_EQ(drive(scene, bent({0, 0, 0.5, 0, 0}), 6, monitor).state, RigState::kError);
  EXPECT_EQ(drive(scene, calibrated(), 1, monitor).state, RigState::kError);
  EXPECT_EQ(drive(scene, calibrated(), 7, monitor).state, RigState::kOk);
}

TEST(RigMonitor, LearnsAReference) {
  RigMonitorOptions options;
  options.learn = 5;
  RigMonitor monitor = monitorOf(options);
  Drive scene({});
  const cv::Vec<double, 5> before(0.5, 0, 0.3, 0, 0), after(0.5, 0, 0.7, 0, 0);
  RigReport report = drive(scene, bent(before), 4, monitor);
  EXPECT_EQ(report.state, RigState::kUnknown);
  EXPECT_FALSE(report.learned);
  report = drive(scene, bent(before), 8, monitor);
  EXPECT_TRUE(report.learned);
  EXPECT_EQ(report.state, RigState::kOk) << report.message;
  EXPECT_LT(angleOfRotation(report.reference, bent(before)), 0.05);
  report = drive(scene, bent(after), 7, monitor);
  EXPECT_EQ(report.state, RigState::kError) << report.message;
  // The correction is the change alone.
  EXPECT_LT(angleOfRotation(report.corrected, bent({0, 0, 0.4, 0, 0})), 0.05);
}

TEST(RigMonitor, WrongMatchesDoNotMoveIt) {
  DriveSpec spec;
  spec.wrong = 0.3;
  Drive scene(spec);
  RigMonitor monitor = monitorOf();
  const RigReport report = drive(scene, bent({0.2, 0, 0, 0, 0}), 6, monitor);
  EXPECT_EQ(report.state, RigState::kWarning) << report.message;
  EXPECT_NEAR(report.deviation[0], 0.2 * kDegree, 0.01 * kDegree);
}

TEST(RigMonitor, AtRestItTakesNothingTwice) {
  Drive scene({});
  const Correspondences matches = scene.next(calibrated());
  RigMonitor monitor = monitorOf();
  const std::size_t first = monitor.add(0, matches);
  EXPECT_GT(first, 100u);
  for (int i = 1; i < 10; ++i) monitor.add(0.1 * i, matches);  // the places that the first pair left out
  for (int i = 10; i < 20; ++i) EXPECT_EQ(monitor.add(0.1 * i, matches), 0u);
  EXPECT_LE(monitor.report().matches, matches.size());
}

TEST(RigMonitor, TooFewMatchesAreUnknown) {
  DriveSpec spec;
  spec.points = 2;
  Drive scene(spec);
  RigMonitor monitor = monitorOf();
  EXPECT_EQ(monitor.report().state, RigState::kUnknown);  // none at all
  const RigReport report = drive(scene, bent({0.5, 0, 0, 0, 0}), 6, monitor);
  EXPECT_EQ(report.state, RigState::kUnknown);
  EXPECT_FALSE(report.determined);
  EXPECT_EQ(report.message.find("too few matches"), 0u) << report.message;
}

TEST(RigMonitor, MatchesThatDetermineNothingAreUnknown) {
  Correspondences matches;
  matches.left_camera = matches.right_camera = camera();
  for (int i = 0; i < 300; ++i)
    matches.add({4.0F * i, 100}, {4.0F * i, 100});  // on a line, and not displaced
  RigMonitor monitor = monitorOf();
  monitor.add(0, matches);
  const RigReport report = monitor.report();
  EXPECT_EQ(report.state, RigState::kUnknown);
}

TEST(RigMonitor, NotFiniteCoordinatesAreLeftOut) {
  Drive scene({});
  Correspondences matches = scene.next(calibrated());
  const std::size_t n = matches.size();
  RigMonitor all = monitorOf(), rest = monitorOf();
  const std::size_t taken = all.add(0, matches);
  for (std::size_t i = 0; i < n; ++i)
    matches.left_x[i] =
        i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : std::numeric_limits<float>::infinity();
  EXPECT_GT(taken, 0u);
  EXPECT_EQ(rest.add(0, matches), 0u);
  EXPECT_EQ(rest.report().state, RigState::kUnknown);
}

TEST(RigMonitor, BadInputIsNamed) {
  const cv::Matx33d eye = cv::Matx33d::eye();
  const cv::Vec3d t(-0.5, 0, 0);
  EXPECT_THROW(RigMonitor({}, eye * 2, t), std::invalid_argument);
  EXPECT_THROW(RigMonitor({}, eye, {0, 0, 0}), std::invalid_argument);
  EXPECT_THROW(RigMonitor({}, eye, {kNaN, 0, 0}), std::invalid_argument);
  RigMonitorOptions options;
  options.error_angle = 0.05;
  EXPECT_THROW(RigMonitor(options, eye, t), std::invalid_argument);
  RigMonitor monitor = monitorOf();
  Correspondences matches = Drive({}).next(calibrated());
  EXPECT_THROW(monitor.add(kNaN, matches), std::invalid_argument);
  matches.right_camera.reset();
  EXPECT_THROW(monitor.add(0, matches), std::invalid_argument);
}

TEST(RigMonitor, PairsBeyondTheLimitsAreLeftOut) {
  RigMonitorOptions options;
  options.window = 2;
  options.max_pairs = 5;
  options.max_matches = 90;
  RigMonitor monitor = monitorOf(options);
  Drive scene({});
  const RigReport report = drive(scene, calibrated(), 10, monitor);
  EXPECT_EQ(report.pairs, 5u);
  EXPECT_LE(report.matches, 5u * 90);
  EXPECT_LE(report.seconds, 2);
  monitor.add(1, scene.next(calibrated()));  // the time goes back
  EXPECT_EQ(monitor.report().pairs, 1u);
}

/// A drive with vibration, wrong matches, moving objects and stops. Two minutes; CORRSEL_RIG_MINUTES and
/// CORRSEL_RIG_SEED set others.
TEST(RigMonitor, NoFalseAlarmsInALongDrive) {
  DriveSpec spec;
  spec.common_noise = 0.01;
  spec.objects = spec.stops = true;
  const auto setting = [](const char* name, double usual) {
    const char* const text = std::getenv(name);
    return text == nullptr ? usual : std::atof(text);
  };
  spec.seed = static_cast<std::uint64_t>(setting("CORRSEL_RIG_SEED", 1));
  const double minutes = setting("CORRSEL_RIG_MINUTES", 2);
  Drive scene(spec);
  RigMonitor monitor = monitorOf();
  int reports = 0, alarms = 0, unknown = 0;
  double largest = 0;
  for (; reports < 60 * minutes; ++reports) {
    const RigReport report = drive(scene, calibrated(), 1, monitor);
    unknown += report.state == RigState::kUnknown;
    const bool alarm = report.state == RigState::kWarning || report.state == RigState::kError;
    if (alarm) std::printf("%.0f s: %s\n", scene.time(), report.message.c_str());
    alarms += alarm;
    if (report.determined) largest = std::max(largest, report.angle);
  }
  std::printf("%d reports, %d unknown, %d alarms, largest significant angle %.3f degrees\n", reports, unknown,
              alarms, largest);
  EXPECT_EQ(alarms, 0);
  EXPECT_LT(unknown, reports / 5);
  // The same monitor still finds a turn.
  const RigReport report = drive(scene, bent({0, 0, 0.4, 0, 0}), 40, monitor);
  EXPECT_EQ(report.state, RigState::kError) << report.message;
}

}  // namespace
}  // namespace corrsel::core
