#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "auto/decision.h"

namespace corrsel::core {
namespace {

using Model = AutoOptions::Model;

constexpr double kSure = 50, kWeak = 1;

/// A significant homography of moving points that leaves nothing over.
Evidence plane() {
  Evidence e;
  e.local_support = true;
  e.homography = {true, cv::Matx33d::eye(), kSure, 20};
  e.homography_leftover = HomographyLeftover{};
  e.parallax = false;
  return e;
}

/// The homography leaves a coherent group over, and there is a significant fundamental matrix.
Evidence space() {
  Evidence e = plane();
  e.homography_leftover->coherent = true;
  e.parallax.reset();
  e.fundamental = FundamentalEvidence{true, cv::Matx33d::eye(), kSure, false};
  e.fundamental_leftover = false;
  return e;
}

/// Neither model is significant.
Evidence weak(double local_confidence) {
  Evidence e = space();
  e.homography.confidence = kWeak;
  e.homography_leftover.reset();
  e.fundamental->confidence = kWeak;
  e.local_confidence = local_confidence;
  return e;
}

struct Case {
  const char* name;
  Evidence evidence;
  Model model;
  Answer answer;
  SceneKind scene;
  const char* message;
  Status status = Status::kOk;
};

Evidence with(Evidence evidence, void (*change)(Evidence&)) {
  change(evidence);
  return evidence;
}

constexpr char kPlaneFound[] = "a plane or a camera that only turns";
constexpr char kSurroundings[] = "matches that agree with their surroundings";

std::vector<Case> cases() {
  const auto loose = [](Evidence& e) {
    e.homography_leftover = HomographyLeftover{false, true};
    e.parallax = false;
  };
  const auto noSpace = [](Evidence& e) { e.fundamental = FundamentalEvidence{}; };
  return {
      {"a plane", plane(), Model::kAuto, Answer::kHomography, SceneKind::kPlaneOrRotation, kPlaneFound},
      {"at rest", with(plane(), [](Evidence& e) { e.homography.displacement = 1; }), Model::kAuto,
       Answer::kHomography, SceneKind::kAtRest, kPlaneFound},
      {"just above", with(plane(), [](Evidence& e) { e.homography.displacement = 1.01; }), Model::kAuto,
       Answer::kHomography, SceneKind::kPlaneOrRotation, kPlaneFound},
      {"loose matches, not explained", with(space(), loose), Model::kAuto, Answer::kHomography,
       SceneKind::kPlaneOrRotation, "a plane; local matches are imprecise"},
      {"loose matches, an insignificant fundamental matrix explains them",
       with(with(space(), loose),
            [](Evidence& e) {
              e.fundamental = {true, {}, kWeak, true};
            }),
       Model::kAuto, Answer::kHomography, SceneKind::kPlaneOrRotation,
       "a plane; local matches are imprecise"},
      {"loose matches, explained",
       with(with(space(), loose), [](Evidence& e) { e.fundamental->explains_loose = true; }), Model::kAuto,
       Answer::kFundamental, SceneKind::kRigid, "epipolar geometry of a rigid scene"},
      {"loose matches, parallax explains them",
       with(with(space(), loose), [](Evidence& e) { e.parallax = true; }), Model::kAuto, Answer::kFundamental,
       SceneKind::kRigid, "epipolar geometry of a rigid scene"},
      {"parallax at rest",
       with(with(space(), loose),
            [](Evidence& e) {
              e.parallax = true;
              e.homography.displacement = 0.5;
            }),
       Model::kAuto, Answer::kHomography, SceneKind::kAtRest, "a plane; local matches are imprecise"},
      {"depth", space(), Model::kAuto, Answer::kFundamental, SceneKind::kRigid,
       "epipolar geometry of a rigid scene"},
      {"parallax",
       with(space(),
            [](Evidence& e) {
              e.homography_leftover->coherent = false;
              e.parallax = true;
            }),
       Model::kAuto, Answer::kFundamental, SceneKind::kRigid, "epipolar geometry of a rigid scene"},
      {"depth without a homography", with(space(), [](Evidence& e) { e.homography = {}; }), Model::kAuto,
       Answer::kFundamental, SceneKind::kRigid, "epipolar geometry of a rigid scene"},
      {"motions beside the epipolar geometry",
       with(space(), [](Evidence& e) { e.fundamental_leftover = true; }), Model::kAuto,
       Answer::kFundamentalAndMore, SceneKind::kSeveralMotions,
       "several motions; the fundamental matrix holds for one of them"},
      {"motions beside a plane",
       with(with(space(), noSpace), [](Evidence& e) { e.local_confidence = kSure; }), Model::kAuto,
       Answer::kHomographyAndMore, SceneKind::kSeveralMotions,
       "several motions; the homography holds for one of them"},
      {"an insignificant group beside a plane",
       with(with(space(), noSpace), [](Evidence& e) { e.local_confidence = kWeak; }), Model::kAuto,
       Answer::kHomography, SceneKind::kPlaneOrRotation, kPlaneFound},
      {"parallax without a significant matrix",
       with(with(plane(), noSpace), [](Evidence& e) { e.parallax = true; }), Model::kAuto,
       Answer::kHomography, SceneKind::kPlaneOrRotation, kPlaneFound},
      {"no support", with(weak(2), [](Evidence& e) { e.local_support = false; }), Model::kAuto,
       Answer::kLocal, SceneKind::kNothing, "nothing agrees more than by chance", Status::kNoModel},
      {"significant surroundings", weak(kSure), Model::kAuto, Answer::kLocal, SceneKind::kUnknown,
       kSurroundings},
      {"insignificant surroundings", weak(2), Model::kAuto, Answer::kLocal, SceneKind::kNothing,
       kSurroundings},
      {"surroundings without a homography", with(weak(0), [](Evidence& e) { e.homography = {}; }),
       Model::kAuto, Answer::kLocal, SceneKind::kNothing, kSurroundings},
      {"an insignificant homography", weak(0.5), Model::kAuto, Answer::kHomography, SceneKind::kNothing,
       kPlaneFound},
      {"told a homography", with(plane(), [](Evidence& e) { e.homography.displacement = 0; }),
       Model::kHomography, Answer::kHomography, SceneKind::kUnknown, kPlaneFound},
      {"told a homography, none", Evidence(), Model::kHomography, Answer::kNothing, SceneKind::kUnknown,
       "no homography was found", Status::kNoModel},
      {"told a fundamental matrix", space(), Model::kFundamental, Answer::kFundamental, SceneKind::kUnknown,
       "epipolar geometry of a rigid scene"},
      {"told a fundamental matrix, none", with(space(), noSpace), Model::kFundamental, Answer::kNothing,
       SceneKind::kUnknown, "no fundamental matrix was found", Status::kNoModel},
  };
}

TEST(Decision, ChoosesEveryRowOfTheTable) {
  for (const Case& c : cases()) {
    const Decision decision = decide(c.evidence, c.model);
    ASSERT_EQ(decision.need, Need::kNone) << c.name;
    EXPECT_EQ(decision.answer, c.answer) << c.name;
    EXPECT_EQ(decision.scene, c.scene) << c.name << ": " << toString(decision.scene);
    EXPECT_EQ(decision.message, c.message) << c.name;
    EXPECT_EQ(decision.status, c.status) << c.name;
  }
}

/// Gathers what is needed from complete evidence. @return the needs in their order
std::vector<Need> needsOf(const Evidence& complete, Model model = Model::kAuto) {
  Evidence known;
  known.local_support = complete.local_support;
  known.homography = complete.homography;
  std::vector<Need> needs;
  for (Decision d; (d = decide(known, model)).need != Need::kNone && needs.size() < 10;) {
    needs.push_back(d.need);
    switch (d.need) {
      case Need::kNone:
        break;
      case Need::kHomographyLeftover:
        known.homography_leftover = complete.homography_leftover.value();
        break;
      case Need::kParallax:
        known.parallax = complete.parallax.value();
        break;
      case Need::kFundamental:
        known.fundamental = complete.fundamental.value();
        break;
      case Need::kFundamentalLeftover:
        known.fundamental_leftover = complete.fundamental_leftover.value();
        break;
      case Need::kLocalConfidence:
        known.local_confidence = complete.local_confidence.value();
        break;
    }
  }
  return needs;
}

using Needs = std::vector<Need>;

TEST(Decision, AsksOnlyForWhatItNeeds) {
  EXPECT_EQ(needsOf(plane()), (Needs{Need::kHomographyLeftover, Need::kParallax}))
      << "the search for a fundamental matrix is the most expensive piece";
  EXPECT_EQ(needsOf(space()),
            (Needs{Need::kHomographyLeftover, Need::kFundamental, Need::kFundamentalLeftover}))
      << "a homography that leaves something over needs no test of parallax";
  EXPECT_EQ(needsOf(weak(2)), (Needs{Need::kFundamental, Need::kLocalConfidence}))
      << "what an insignificant homography leaves over says nothing";
  EXPECT_EQ(needsOf(plane(), Model::kHomography), Needs{});
  EXPECT_EQ(needsOf(space(), Model::kFundamental), Needs{Need::kFundamental});
}

}  // namespace
}  // namespace corrsel::core
