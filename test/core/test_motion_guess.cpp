#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>

#include "base/gather.h"
#include "calibrated_scene.h"
#include "corrsel/correspondences.h"
#include "corrsel/motion_guess.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/factory.h"
#include "geometry/rotation_vector.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using calibrated_scene::Scenario;
using calibrated_scene::Scene;
using calibrated_scene::SceneOptions;
using testing::errorOf;
using testing::mentions;

constexpr double kDegree = CV_PI / 180;

/// The rotation about a random axis.
cv::Matx33d turnBy(double degrees, Random& random) {
  const cv::Vec3d w = pose_scene::randomDirection(random) * (degrees * kDegree);
  return moved({cv::Matx33d::eye(), {0, 0, 1}}, {w[0], w[1], w[2], 0, 0}).rotation;
}

MotionGuess guessOff(const Scene& scene, double degrees, double sigma_degrees, Random& random) {
  MotionGuess guess;
  guess.rotation = turnBy(degrees, random) * scene.truth.rotation;
  guess.rotation_sigma = sigma_degrees * kDegree;
  return guess;
}

void expectSame(const Selection& with, const Selection& without) {
  EXPECT_EQ(with.mask, without.mask);
  EXPECT_EQ(with.model, without.model);
  EXPECT_EQ(with.status, without.status);
  EXPECT_EQ(with.iterations, without.iterations);
  EXPECT_EQ(with.message, without.message);
  EXPECT_TRUE(with.confidence == without.confidence || std::isnan(without.confidence));
  ASSERT_EQ(with.pose.has_value(), without.pose.has_value());
  if (!with.pose) return;
  EXPECT_EQ(with.pose->pose.rotation, without.pose->pose.rotation);
  EXPECT_EQ(with.pose->pose.translation, without.pose->pose.translation);
  EXPECT_EQ(with.pose->motion, without.pose->motion);
}

TEST(MotionGuess, ErrorsNameTheMember) {
  const auto error = [](const MotionGuess& guess) {
    return errorOf<std::invalid_argument>([&] { guess.check(); });
  };
  MotionGuess valid;
  EXPECT_NO_THROW(valid.check());
  valid.translation = cv::Vec3d(0, 0.6, -0.8);
  valid.rotation_sigma = 0.1;
  EXPECT_NO_THROW(valid.check());
  MotionGuess changed = valid;
  changed.rotation = cv::Matx33d::eye() * 1.01;
  EXPECT_TRUE(mentions(error(changed), {"rotation = [1.01 ", "rows"}));
  changed.rotation = cv::Matx33d::eye() * -1;
  EXPECT_TRUE(mentions(error(changed), {"rotation", "determinant"}));
  changed = valid;
  changed.translation = cv::Vec3d(0, 0, 2);
  EXPECT_TRUE(mentions(error(changed), {"translation = [0 0 2]", "length 1"}));
  changed.translation = cv::Vec3d(0, std::nan(""), 1);
  EXPECT_TRUE(mentions(error(changed), {"translation", "finite"}));
  changed = valid;
  for (const auto& [text, sigma] : std::map<std::string, double>{
           {"-0.5", -0.5}, {"nan", std::nan("")}, {"inf", std::numeric_limits<double>::infinity()}}) {
    changed.rotation_sigma = sigma;
    EXPECT_TRUE(mentions(error(changed), {"rotation_sigma = " + text + " rad", "from 0"}));
  }
}

TEST(MotionGuess, BelongsToTheMatches) {
  Correspondences matches;
  matches.add({1, 2}, {3, 4});
  matches.guess.emplace().rotation_sigma = 0.25;
  EXPECT_EQ(matches.inconsistency(), "");
  Correspondences gathered;
  gather(matches, {0}, gathered);
  for (const Correspondences& copy : {matches.subset({0}), gathered}) {
    ASSERT_TRUE(copy.guess);
    EXPECT_EQ(copy.guess->rotation_sigma, 0.25);
  }
  matches.guess->rotation_sigma = -1;
  EXPECT_TRUE(mentions(matches.inconsistency(), {"guess.rotation_sigma = -1"}));
}

TEST(MotionGuess, TextsOfVerdicts) {
  EXPECT_EQ(toString(GuessVerdict::kNone), "none");
  EXPECT_EQ(toString(GuessVerdict::kConfirmed), "confirmed");
  EXPECT_EQ(toString(GuessVerdict::kContradicted), "contradicted");
  EXPECT_EQ(toString(GroupMotion::kUnknown), "unknown");
  EXPECT_EQ(toString(GroupMotion::kStatic), "static");
  EXPECT_EQ(toString(GroupMotion::kMoving), "moving");
}

TEST(MotionGuess, ARightOneIsConfirmedByFewerHypotheses) {
  SceneOptions options;
  options.noise = 0.5;
  options.size = 500;
  options.right_share = 0.15;
  const auto selector = createSelector("pose");
  for (const bool translates : {false, true}) {
    for (const Scenario scenario : {Scenario::kGeneral, Scenario::kForward, Scenario::kRotation}) {
      options.scenario = scenario;
      Scene scene = calibrated_scene::generate(options, 3);
      const Selection without = selector->select(scene.matches);
      Random random(5);
      scene.matches.guess = guessOff(scene, 0.5, 0.5, random);
      if (translates && scenario != Scenario::kRotation)
        scene.matches.guess->translation = scene.truth.translation;
      const Selection with = selector->select(scene.matches);
      ASSERT_EQ(with.status, Status::kOk);
      ASSERT_TRUE(with.pose);
      EXPECT_EQ(with.guess, GuessVerdict::kConfirmed);
      EXPECT_LT(cv::norm(rotationVector(with.pose->pose.rotation * scene.truth.rotation.t())), 0.3 * kDegree);
      // Without a translation any essential matrix of the rotation fits, and the guess may not be refined.
      if (scenario != Scenario::kRotation) {
        EXPECT_LT(2 * with.iterations, without.iterations);
      }
    }
  }
}

TEST(MotionGuess, FindsWhatIsNotFoundWithoutIt) {
  SceneOptions options;
  options.noise = 0.5;
  options.size = 800;
  options.right_share = 0.04;
  const auto selector = createSelector("pose");
  int found_with = 0, found_without = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    Scene scene = calibrated_scene::generate(options, seed);
    const auto isFound = [&](const Selection& selection) {
      if (selection.status != Status::kOk || !selection.pose) return false;
      const cv::Matx33d& rotation = selection.pose->pose.rotation;
      return cv::norm(rotationVector(rotation * scene.truth.rotation.t())) < 0.5 * kDegree;
    };
    found_without += isFound(selector->select(scene.matches)) ? 1 : 0;
    Random random(seed);
    scene.matches.guess = guessOff(scene, 0.2, 0.2, random);
    found_with += isFound(selector->select(scene.matches)) ? 1 : 0;
  }
  EXPECT_GE(found_with, 5);
  EXPECT_LE(found_without, 2);
}

TEST(MotionGuess, AWrongOneChangesNothing) {
  SceneOptions options;
  options.noise = 0.5;
  const auto selector = createSelector("pose");
  Random random(7);
  for (const Scenario scenario :
       {Scenario::kRest, Scenario::kRotation, Scenario::kGeneral, Scenario::kForward, Scenario::kPlane}) {
    for (const double share : {0.15, 0.5}) {
      options.scenario = scenario;
      options.right_share = share;
      Scene scene = calibrated_scene::generate(options, 11);
      const Selection without = selector->select(scene.matches);
      EXPECT_EQ(without.guess, GuessVerdict::kNone);
      for (const double degrees : {5.0, 10.0, 20.0, 60.0}) {
        scene.matches.guess = guessOff(scene, degrees, 0.5, random);
        if (degrees > 10) scene.matches.guess->translation = pose_scene::randomDirection(random);
        const Selection with = selector->select(scene.matches);
        expectSame(with, without);
        EXPECT_EQ(with.guess, without.pose ? GuessVerdict::kContradicted : GuessVerdict::kNone) << degrees;
      }
    }
  }
}

TEST(MotionGuess, NothingIsConfirmedWithoutAnAnswer) {
  SceneOptions options;
  options.right_share = 0;
  Scene scene = calibrated_scene::generate(options, 2);
  const auto selector = createSelector("pose");
  const Selection without = selector->select(scene.matches);
  Random random(1);
  scene.matches.guess = guessOff(scene, 0, 1, random);
  const Selection with = selector->select(scene.matches);
  expectSame(with, without);
  EXPECT_EQ(with.guess, GuessVerdict::kNone);
}

TEST(MotionGuess, AutoPassesItThroughAndOthersIgnoreIt) {
  SceneOptions options;
  options.noise = 0.5;
  Scene scene = calibrated_scene::generate(options, 1);
  Random random(3);
  for (const char* name : {"auto", "usac:e", "gms"}) {
    const auto selector = createSelector(name);
    scene.matches.guess.reset();
    const Selection without = selector->select(scene.matches);
    scene.matches.guess = guessOff(scene, 20, 0.5, random);
    const Selection wrong = selector->select(scene.matches);
    expectSame(wrong, without);
    const bool tests = name == std::string("auto");
    EXPECT_EQ(wrong.guess, tests ? GuessVerdict::kContradicted : GuessVerdict::kNone) << name;
    scene.matches.guess = guessOff(scene, 0.5, 0.5, random);
    EXPECT_EQ(selector->select(scene.matches).guess, tests ? GuessVerdict::kConfirmed : GuessVerdict::kNone);
  }
}

}  // namespace
}  // namespace corrsel::core
