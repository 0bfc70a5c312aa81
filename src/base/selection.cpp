#include "corrsel/selection.h"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"

namespace corrsel::core {
namespace {

template <class Value>
using Text = std::pair<Value, const char*>;

constexpr Text<Status> kStatusTexts[] = {
    {Status::kOk, "ok"},
    {Status::kTooFew, "too_few"},
    {Status::kDegenerate, "degenerate"},
    {Status::kNoModel, "no_model"},
    {Status::kUnsupportedInput, "unsupported_input"},
    {Status::kTooLarge, "too_large"},
    {Status::kTimeLimit, "time_limit"},
    {Status::kFailed, "failed"},
    {Status::kUncertain, "uncertain"},
};

constexpr Text<ModelKind> kModelTexts[] = {
    {ModelKind::kNone, "none"},
    {ModelKind::kHomography, "homography"},
    {ModelKind::kFundamental, "fundamental"},
    {ModelKind::kEssential, "essential"},
    {ModelKind::kRotation, "rotation"},
};

constexpr Text<SceneKind> kSceneTexts[] = {
    {SceneKind::kUnknown, "unknown"}, {SceneKind::kNothing, "nothing"},
    {SceneKind::kAtRest, "at_rest"},  {SceneKind::kPlaneOrRotation, "plane_or_rotation"},
    {SceneKind::kRigid, "rigid"},     {SceneKind::kSeveralMotions, "several_motions"},
};

constexpr Text<Motion> kMotionTexts[] = {
    {Motion::kNone, "none"},       {Motion::kRest, "rest"},     {Motion::kRotation, "rotation"},
    {Motion::kGeneral, "general"}, {Motion::kPlanar, "planar"},
};

constexpr Text<GroupMotion> kGroupMotionTexts[] = {
    {GroupMotion::kUnknown, "unknown"},
    {GroupMotion::kStatic, "static"},
    {GroupMotion::kMoving, "moving"},
};

constexpr Text<GuessVerdict> kGuessTexts[] = {
    {GuessVerdict::kNone, "none"},
    {GuessVerdict::kConfirmed, "confirmed"},
    {GuessVerdict::kContradicted, "contradicted"},
};

template <class Value, std::size_t N>
std::string textOf(Value wanted, const Text<Value> (&texts)[N], const std::string& what) {
  for (const auto& [value, text] : texts) {
    if (value == wanted) return text;
  }
  throw std::invalid_argument("unknown " + what + " " + std::to_string(static_cast<int>(wanted)));
}

template <class Value, std::size_t N>
Value valueOf(const std::string& wanted, const Text<Value> (&texts)[N], const std::string& what) {
  std::vector<std::string> valid;
  for (const auto& [value, text] : texts) {
    if (wanted == text) return value;
    valid.emplace_back(text);
  }
  throw std::invalid_argument("unknown " + what + " '" + wanted + "'" + validNames(wanted, valid));
}

}  // namespace

std::string toString(Status status) { return textOf(status, kStatusTexts, "status"); }

Status statusFromString(const std::string& text) { return valueOf(text, kStatusTexts, "status"); }

std::string toString(ModelKind kind) { return textOf(kind, kModelTexts, "model kind"); }

std::string toString(SceneKind kind) { return textOf(kind, kSceneTexts, "scene"); }

std::string toString(Motion motion) { return textOf(motion, kMotionTexts, "motion"); }

std::string toString(GroupMotion motion) { return textOf(motion, kGroupMotionTexts, "motion of a group"); }

std::string toString(GuessVerdict verdict) { return textOf(verdict, kGuessTexts, "verdict about a guess"); }

Motion motionFromString(const std::string& text) { return valueOf(text, kMotionTexts, "motion"); }

SceneKind sceneFromString(const std::string& text) { return valueOf(text, kSceneTexts, "scene"); }

}  // namespace corrsel::core
