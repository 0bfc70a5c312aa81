#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <sstream>
#include <vector>

#include "corrsel/gyroscope.h"
#include "corrsel/random.h"
#include "geometry/rotation_vector.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

constexpr double kDegree = M_PI / 180;

std::int64_t ns(double seconds) { return std::llround(1e9 * seconds); }

double angleBetween(const cv::Matx33d& a, const cv::Matx33d& b) {
  return cv::norm(rotationVector(a.t() * b));
}

/// The rates of a body whose orientation is exp([a(t)]x) about a fixed axis, plus a bias and noise.
struct Motion {
  cv::Vec3d axis = cv::normalize(cv::Vec3d(1, -2, 0.5));
  std::function<double(double)> angle = [](double t) { return 0.8 * t; };  ///< rad
  cv::Vec3d bias;
  double noise = 0;  ///< rad/s

  cv::Vec3d rate(double t, Random& random) const {
    constexpr double kStep = 1e-5;
    cv::Vec3d value = axis * ((angle(t + kStep) - angle(t - kStep)) / (2 * kStep)) + bias;
    for (int k = 0; k < 3; ++k) value[k] += noise * random.normal();
    return value;
  }
  void feed(Gyroscope& gyroscope, double begin, double end, double frequency) const {
    Random random(7);
    for (int i = 0; begin + i / frequency <= end + 1e-9; ++i) {
      const double t = begin + i / frequency;
      EXPECT_TRUE(gyroscope.add(ns(t), rate(t, random)));
    }
  }
  /// Takes a direction at time `from` to one at time `to`.
  cv::Matx33d truth(double from, double to) const {
    return rotationFromVector(axis * (angle(from) - angle(to)));
  }
};

TEST(Gyroscope, AnEvenTurnIsExactAtEveryFrequency) {
  const Motion motion;
  for (const double frequency : {50.0, 200.0, 1000.0, 333.3}) {
    Gyroscope gyroscope;
    motion.feed(gyroscope, 0, 2, frequency);
    const auto turn = gyroscope.between(ns(1.5077), ns(0.5013));
    ASSERT_TRUE(turn) << frequency;
    EXPECT_LT(angleBetween(turn->rotation, motion.truth(1.5077, 0.5013)), 1e-6) << frequency;
    const auto back = gyroscope.between(ns(0.5013), ns(1.5077));
    ASSERT_TRUE(back);
    EXPECT_LT(cv::norm(back->rotation - turn->rotation.t()), 1e-12);
    EXPECT_EQ(back->sigma, turn->sigma);
  }
}

TEST(Gyroscope, TheDirectionIsThatOfThePose) {
  // The camera turns to the right (about y, down): a point ahead moves to the left of the newer image.
  Motion motion;
  motion.axis = {0, 1, 0};
  motion.angle = [](double t) { return 0.5 * t; };
  Gyroscope gyroscope;
  motion.feed(gyroscope, 0, 1, 100);
  const auto turn = gyroscope.between(ns(1), ns(0));
  ASSERT_TRUE(turn);
  const cv::Vec3d ahead_now(0, 0, 1), then = turn->rotation * ahead_now;
  EXPECT_NEAR(then[0], std::sin(0.5), 1e-6) << "what is ahead now was on the right before";
}

TEST(Gyroscope, ATurnAboutAChangingAxisIsComposedInTheOrderOfTime) {
  Gyroscope gyroscope;
  for (int i = 0; i <= 2000; ++i) {  // first about x, then about y
    gyroscope.add(ns(i * 1e-3), i < 1000 ? cv::Vec3d(1, 0, 0) : cv::Vec3d(0, 1, 0));
  }
  const auto turn = gyroscope.between(ns(2), ns(0));
  ASSERT_TRUE(turn);
  const cv::Matx33d truth = rotationFromVector({1, 0, 0}) * rotationFromVector({0, 1, 0});
  EXPECT_LT(angleBetween(turn->rotation, truth), 2e-3);
}

TEST(Gyroscope, TheStandardDeviationHoldsForNoiseAndAnUnevenTurn) {
  Motion motion;
  motion.angle = [](double t) { return 0.6 * std::sin(5 * t); };
  motion.noise = 1e-3 * std::sqrt(200.0);  // the default density at 200 Hz
  Gyroscope gyroscope;
  motion.feed(gyroscope, 0, 9, 200);
  int within = 0, all = 0;
  double largest = 0;
  for (double t = 0.5; t < 9; t += 0.1, ++all) {
    const auto turn = gyroscope.between(ns(t), ns(t - 0.1));
    ASSERT_TRUE(turn);
    const double error = angleBetween(turn->rotation, motion.truth(t, t - 0.1));
    within += error < 3 * turn->sigma ? 1 : 0;
    largest = std::max(largest, turn->sigma);
  }
  EXPECT_EQ(within, all);
  EXPECT_LT(largest, 1 * kDegree) << "an uncertainty that is too large helps nobody";
}

TEST(Gyroscope, TheBiasIsWhatItShowsAtRest) {
  Motion rest;
  rest.angle = [](double) { return 0.0; };
  rest.bias = {0.02, -0.05, 0.08};
  rest.noise = 0.01;
  Gyroscope gyroscope;
  EXPECT_FALSE(gyroscope.bias().known);
  rest.feed(gyroscope, 0, 0.9, 200);
  EXPECT_FALSE(gyroscope.bias().known) << "too short";
  rest.feed(gyroscope, 0.905, 3, 200);
  ASSERT_TRUE(gyroscope.bias().known);
  EXPECT_LT(cv::norm(gyroscope.bias().rate - rest.bias), 0.003);
  EXPECT_LT(gyroscope.bias().sigma, 0.003);
  Motion turning = rest;
  turning.angle = [](double t) { return 1.5 * std::sin(t); };
  turning.feed(gyroscope, 3.005, 6, 200);
  EXPECT_LT(cv::norm(gyroscope.bias().rate - rest.bias), 0.003) << "turning is not rest";
  const auto turn = gyroscope.between(ns(5), ns(4));
  ASSERT_TRUE(turn);
  EXPECT_LT(angleBetween(turn->rotation, turning.truth(5, 4)), std::min(3 * turn->sigma, 0.4 * kDegree));
}

TEST(Gyroscope, NeitherFastTurnsNorUnevenOnesAreRest) {
  Motion fast;
  fast.angle = [](double t) { return 0.3 * t; };
  Motion uneven;
  uneven.angle = [](double t) { return 0.05 * std::sin(2 * t); };
  for (const Motion& motion : {fast, uneven}) {
    Gyroscope gyroscope;
    motion.feed(gyroscope, 0, 10, 200);
    EXPECT_FALSE(gyroscope.bias().known);
  }
}

TEST(Gyroscope, AnEvenSlowTurnIsCorrectedByTheNextRest) {
  Motion slow;
  slow.angle = [](double t) { return 0.05 * t; };
  slow.noise = 0.002;
  Motion rest = slow;
  rest.angle = [](double) { return 0.0; };
  Gyroscope gyroscope;
  slow.feed(gyroscope, 0, 2, 200);
  ASSERT_TRUE(gyroscope.bias().known) << "it cannot be told from rest";
  rest.feed(gyroscope, 2.005, 5, 200);
  EXPECT_LT(cv::norm(gyroscope.bias().rate), 0.01);
  EXPECT_GT(gyroscope.bias().sigma, 0.03) << "one of the two was no rest";
}

TEST(Gyroscope, GapsAreBridgedUpToTheirLimit) {
  const Motion motion;
  Gyroscope gyroscope;
  motion.feed(gyroscope, 0, 1, 200);
  motion.feed(gyroscope, 1.04, 2, 200);  // 0.04 s
  motion.feed(gyroscope, 2.2, 3, 200);   // 0.2 s
  const auto bridged = gyroscope.between(ns(1.5), ns(0.5));
  ASSERT_TRUE(bridged);
  EXPECT_LT(angleBetween(bridged->rotation, motion.truth(1.5, 0.5)), 1e-6);
  EXPECT_FALSE(gyroscope.between(ns(2.5), ns(1.5)));
  EXPECT_FALSE(gyroscope.between(ns(2.5), ns(2.1))) << "it begins in the gap";
  EXPECT_FALSE(gyroscope.between(ns(2.1), ns(1.9))) << "it ends in the gap";
  EXPECT_TRUE(gyroscope.between(ns(2.9), ns(2.2)));
}

TEST(Gyroscope, WhatTheSamplesDoNotCoverIsUnknown) {
  const Motion motion;
  Gyroscope gyroscope;
  EXPECT_FALSE(gyroscope.newest());
  EXPECT_FALSE(gyroscope.between(ns(1), ns(0)));
  motion.feed(gyroscope, 1, 20, 100);
  EXPECT_EQ(gyroscope.newest(), ns(20));
  EXPECT_FALSE(gyroscope.between(ns(20.001), ns(19))) << "after the newest";
  EXPECT_FALSE(gyroscope.between(ns(19), ns(5))) << "forgotten";
  EXPECT_TRUE(gyroscope.between(ns(20), ns(11)));
  const auto none = gyroscope.between(ns(15), ns(15));
  ASSERT_TRUE(none);
  EXPECT_EQ(none->rotation, cv::Matx33d::eye());
  EXPECT_EQ(none->sigma, 0);
}

TEST(Gyroscope, ATimeThatGoesBackDropsTheSamplesAndKeepsTheBias) {
  Motion motion;
  motion.bias = {0.01, 0, 0};
  motion.angle = [](double) { return 0.0; };
  Gyroscope gyroscope;
  motion.feed(gyroscope, 100, 103, 200);
  ASSERT_TRUE(gyroscope.bias().known);
  motion.feed(gyroscope, 0, 1, 200);
  EXPECT_EQ(gyroscope.newest(), ns(1));
  EXPECT_FALSE(gyroscope.between(ns(102), ns(101)));
  EXPECT_TRUE(gyroscope.between(ns(1), ns(0)));
  EXPECT_LT(cv::norm(gyroscope.bias().rate - motion.bias), 1e-6);
}

TEST(Gyroscope, SamplesThatAreNoneAreSkipped) {
  Gyroscope gyroscope;
  EXPECT_FALSE(gyroscope.add(1, {0, std::numeric_limits<double>::quiet_NaN(), 0}));
  EXPECT_FALSE(gyroscope.add(1, {std::numeric_limits<double>::infinity(), 0, 0}));
  EXPECT_FALSE(gyroscope.newest());
  EXPECT_TRUE(gyroscope.add(5, {1, 0, 0}));
  EXPECT_TRUE(gyroscope.add(5, {2, 0, 0})) << "a repeated stamp";
  EXPECT_EQ(gyroscope.newest(), 5);
  GyroscopeOptions options;
  options.window = 0;
  EXPECT_NE(errorOf([&] { const Gyroscope wrong(options); }).find("window"), std::string::npos);
}

/// The gyroscope of a drone that stands on the floor with its rotors running, and has a bias of 4.6 deg/s.
TEST(Gyroscope, EurocAtRest) {
  const std::string folder = sharedData("euroc_rest");
  if (folder.empty()) GTEST_SKIP() << "skipped: euroc_rest is not here";
  std::ifstream file(folder + "/imu0/data.csv");
  std::string line;
  std::getline(file, line);
  Gyroscope gyroscope;
  std::vector<std::int64_t> stamps;
  std::optional<Gyroscope::Bias> of_first_second;
  while (std::getline(file, line)) {
    std::istringstream numbers(line);
    std::int64_t stamp = 0;
    cv::Vec3d rate;
    char comma = 0;
    numbers >> stamp >> comma >> rate[0] >> comma >> rate[1] >> comma >> rate[2];
    ASSERT_TRUE(numbers) << line;
    ASSERT_TRUE(gyroscope.add(stamp, rate));
    stamps.push_back(stamp);
    if (!of_first_second && gyroscope.bias().known) of_first_second = gyroscope.bias();
  }
  ASSERT_GT(stamps.size(), 390u);
  ASSERT_TRUE(of_first_second);
  EXPECT_LT(cv::norm(of_first_second->rate - gyroscope.bias().rate), 4 * of_first_second->sigma);
  const auto turn = gyroscope.between(stamps.back(), stamps.front());
  ASSERT_TRUE(turn);
  const double angle = cv::norm(rotationVector(turn->rotation));
  std::printf("turned %.4f +- %.4f deg in 2 s, %.4f deg with the bias of the first second\n", angle / kDegree,
              turn->sigma / kDegree, cv::norm(of_first_second->rate - gyroscope.bias().rate) * 2 / kDegree);
  EXPECT_LT(angle, 0.2 * kDegree);
  EXPECT_LT(angle, 3 * turn->sigma);
  EXPECT_LT(turn->sigma, 0.5 * kDegree);
}

}  // namespace
}  // namespace corrsel::core
