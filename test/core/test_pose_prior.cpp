#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "base/gather.h"
#include "calibrated_scene.h"
#include "corrsel/correspondences.h"
#include "corrsel/pose_prior.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"
#include "geometry/known_motion.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::errorOf;
using testing::mentions;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

cv::Matx33d quarterTurn() { return {0, -1, 0, 1, 0, 0, 0, 0, 1}; }

TEST(PosePrior, DirectionsGetLengthOne) {
  const PosePrior vertical = PosePrior::ofVertical({0, 9.81, 0}, {0, 3, 4});
  EXPECT_EQ(vertical.kind, PosePrior::Kind::kVertical);
  EXPECT_EQ(vertical.left_down, cv::Vec3d(0, 1, 0));
  EXPECT_LT(cv::norm(vertical.right_down - cv::Vec3d(0, 0.6, 0.8)), 1e-15);
  const PosePrior rig = PosePrior::ofRig(quarterTurn(), {-0.25, 0, 0});
  EXPECT_EQ(rig.kind, PosePrior::Kind::kRig);
  EXPECT_EQ(rig.rotation, quarterTurn());
  EXPECT_EQ(rig.translation, cv::Vec3d(-1, 0, 0));
  const PosePrior rotation = PosePrior::ofRotation(quarterTurn());
  EXPECT_EQ(rotation.kind, PosePrior::Kind::kRotation);
  EXPECT_EQ(rotation.rotation, quarterTurn());
  for (const PosePrior& prior : {vertical, rig, rotation}) EXPECT_NO_THROW(prior.check());
}

TEST(PosePrior, ErrorsNameTheMember) {
  const auto error = [](const PosePrior& prior) {
    return errorOf<std::invalid_argument>([&] { prior.check(); });
  };
  const cv::Vec3d down(0, 1, 0);
  EXPECT_TRUE(mentions(error(PosePrior::ofRotation(cv::Matx33d::eye() * 1.01)), {"rotation", "rows"}));
  EXPECT_TRUE(mentions(error(PosePrior::ofRotation(cv::Matx33d::eye() * -1)), {"rotation", "determinant"}));
  EXPECT_TRUE(mentions(error(PosePrior::ofRotation(cv::Matx33d::all(kNan))), {"rotation", "finite"}));
  EXPECT_TRUE(mentions(error(PosePrior::ofVertical({0, 0, 0}, down)), {"left_down = [0 0 0]", "length 1"}));
  EXPECT_TRUE(mentions(error(PosePrior::ofVertical(down, {0, kNan, 0})), {"right_down", "finite"}));
  EXPECT_TRUE(mentions(error(PosePrior::ofRig(quarterTurn(), {})), {"translation", "length 1"}));
  EXPECT_TRUE(mentions(error(PosePrior::ofRig(cv::Matx33d::zeros(), down)), {"rotation"}));
  PosePrior changed = PosePrior::ofVertical(down, down);
  changed.right_down *= 1.001;
  EXPECT_TRUE(mentions(error(changed), {"right_down", "length 1"}));
  changed.kind = static_cast<PosePrior::Kind>(3);
  EXPECT_TRUE(mentions(error(changed), {"kind = 3", "0 to 2"}));
}

TEST(PosePrior, BelongsToTheMatches) {
  Correspondences matches;
  matches.add({1, 2}, {3, 4});
  matches.prior = PosePrior::ofRotation(quarterTurn());
  EXPECT_EQ(matches.inconsistency(), "");
  Correspondences gathered;
  gather(matches, {0}, gathered);
  for (const Correspondences& copy : {matches.subset({0}), gathered}) {
    ASSERT_TRUE(copy.prior);
    EXPECT_EQ(copy.prior->rotation, quarterTurn());
  }
  gather(Correspondences(), {}, gathered);
  EXPECT_FALSE(gathered.prior);
  matches.prior->rotation(0, 0) = 5;
  EXPECT_TRUE(mentions(matches.inconsistency(), {"prior.rotation = [5 "}));
}

TEST(PosePrior, OtherSelectorsIgnoreIt) {
  calibrated_scene::SceneOptions options;
  options.noise = 0.5;
  Correspondences matches = calibrated_scene::generate(options, 1).matches;
  for (const char* name : {"usac:e", "auto"}) {
    const auto selector = createSelector(name);
    matches.prior.reset();
    const Selection without = selector->select(matches);
    matches.prior = PosePrior::ofRig(quarterTurn(), {1, 0, 0});
    const Selection with = selector->select(matches);
    EXPECT_EQ(with.mask, without.mask) << name;
    EXPECT_EQ(with.model, without.model) << name;
  }
}

TEST(PosePrior, TheNearestRotationSatisfiesIt) {
  Random random(1);
  for (int round = 0; round < 100; ++round) {
    const cv::Matx33d rotation = pose_scene::randomPose(random).rotation;
    const cv::Vec3d left = pose_scene::randomDirection(random);
    const cv::Vec3d right = pose_scene::randomDirection(random);
    const cv::Matx33d turned = constrained(PosePrior::ofVertical(left, right), rotation);
    EXPECT_LT(cv::norm(turned * left - right), 1e-13);
    EXPECT_LT(cv::norm(turned * turned.t() - cv::Matx33d::eye()), 1e-13);
    // The smallest turn moves the direction by its angle.
    const double angle = std::acos((cv::trace(turned * rotation.t()) - 1) / 2);
    EXPECT_NEAR(angle, pose_scene::angleBetween(rotation * left, right), 1e-6);
  }
  EXPECT_EQ(constrained(std::nullopt, quarterTurn()), quarterTurn());
  EXPECT_EQ(constrained(PosePrior::ofRotation(quarterTurn()), cv::Matx33d::eye()), quarterTurn());
}

TEST(PosePrior, OppositeDirectionsAreHalfATurnApart) {
  const cv::Vec3d up(0, -1, 0), down(0, 1, 0);
  const cv::Matx33d turned = constrained(PosePrior::ofVertical(up, down), cv::Matx33d::eye());
  EXPECT_LT(cv::norm(turned * up - down), 1e-15);
  EXPECT_LT(cv::norm(turned * turned.t() - cv::Matx33d::eye()), 1e-15);
  EXPECT_NEAR(cv::determinant(turned), 1, 1e-15);
}

TEST(PosePrior, LeavesDirectionsFree) {
  const cv::Vec3d down(0, 0.6, 0.8);
  EXPECT_EQ(freedomOf(std::nullopt).size, 5);
  EXPECT_EQ(freedomOf(PosePrior::ofRotation(quarterTurn())).size, 2);
  const PoseFreedom vertical = freedomOf(PosePrior::ofVertical({0, 1, 0}, down));
  EXPECT_EQ(vertical.size, 3);
  EXPECT_EQ(vertical.directions[2], (cv::Vec<double, 5>(0, 0.6, 0.8, 0, 0)));
  EXPECT_EQ(freedomOf(PosePrior::ofRig(quarterTurn(), down)).size, 0);
}

}  // namespace
}  // namespace corrsel::core
