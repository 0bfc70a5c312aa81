#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <opencv2/core/matx.hpp>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/motion_guess.h"
#include "corrsel/pose_result.h"

namespace corrsel::core {

/// Outcome of a selection. The texts returned by toString() are part of the file formats.
enum class Status : std::uint8_t {
  kOk = 0,
  kTooFew = 1,            ///< fewer matches than the method needs: nothing selected
  kDegenerate = 2,        ///< the configuration (all equal, collinear) cannot be decided: see the message
  kNoModel = 3,           ///< the search ended without a model
  kUnsupportedInput = 4,  ///< a column or an image size that the method needs is missing
  kTooLarge = 5,          ///< more matches than memory or time options allow
  kTimeLimit = 6,         ///< stopped at max_seconds: best result so far
  kFailed = 7,            ///< the method reported an internal error
  /// The answer is complete, but its confidence is below `min_confidence`: mask and model are those of `ok`,
  /// and they should not be relied on.
  kUncertain = 8
};

std::string toString(Status status);

/// Throws std::invalid_argument listing the valid texts.
Status statusFromString(const std::string& text);

enum class ModelKind : std::uint8_t {
  kNone = 0,
  kHomography = 1,   ///< x' ~ H x, px
  kFundamental = 2,  ///< x'^T F x = 0, px
  kEssential = 3,    ///< d'^T E d = 0 for unit rays of calibrated cameras
  kRotation = 4      ///< d' = R d for unit rays of calibrated cameras
};

std::string toString(ModelKind kind);

/// What the matches show, as far as a selector found it out. The texts returned by toString() are part of the
/// file formats.
enum class SceneKind : std::uint8_t {
  kUnknown = 0,          ///< the selector does not find it out, or no model holds for what agrees
  kNothing = 1,          ///< chance explains all that agrees: the images may show different scenes
  kAtRest = 2,           ///< the images show the same view; neither camera nor scene has moved
  kPlaneOrRotation = 3,  ///< one homography: a plane, or a camera that only turns
  kRigid = 4,            ///< one fundamental matrix: a rigid scene with depth
  kSeveralMotions = 5    ///< no single model: objects move by themselves
};

std::string toString(SceneKind kind);

/// Throws std::invalid_argument listing the valid texts.
SceneKind sceneFromString(const std::string& text);

/// What a group of matches does, see labelMotion(). The texts returned by toString() are part of the file
/// formats.
enum class GroupMotion : std::uint8_t {
  kUnknown = 0,
  kStatic = 1,  ///< it is the scene, which moves in the image because the camera does
  kMoving = 2   ///< an object that moves by itself
};

std::string toString(GroupMotion motion);

/// The result of a selector.
struct Selection {
  std::vector<std::uint8_t> mask;  ///< 1 = selected, 0 = rejected; always as long as the input
  std::vector<float>
      score;  ///< optional, per match: higher is better, meaning given by the method; NaN = none
  /// Optional, per match: the number of the model or cluster that a selected match belongs to; -1 = not
  /// selected, or selected without belonging to one. Empty for methods that do not tell groups apart, and
  /// where nothing was found. Numbers begin at 0, and the strongest group comes first: models are in the
  /// order in which they were found, clusters begin with the largest, and equal ones are in the order of the
  /// coordinates of their first matches.
  std::vector<std::int32_t> group;
  /// Optional, per group: what it does. Empty where nobody has found it out, see labelMotion().
  std::vector<GroupMotion> motion;
  ModelKind model_kind = ModelKind::kNone;
  cv::Matx33d model = cv::Matx33d::zeros();  ///< left to right, see ModelKind; valid if kind is not kNone
  Status status = Status::kOk;
  SceneKind scene = SceneKind::kUnknown;  ///< what the matches show; `auto` finds it out
  /// -log10 of the number of agreements as good as this one that outliers alone are expected to show; at
  /// least 0. It is 0 where chance explains the agreement, and NaN where nobody has computed it, see
  /// addConfidence().
  double confidence = std::numeric_limits<double>::quiet_NaN();
  /// Noise of the inliers of the model: the standard deviation of each coordinate of their residual (the
  /// smaller transfer error of a homography, the Sampson distance of a fundamental matrix), px. NaN where
  /// there is no model, and where nobody has computed it, see addProbability().
  double sigma = std::numeric_limits<double>::quiet_NaN();
  /// Optional, per match: the probability that the match is right, from 0 to 1, whether it is selected or
  /// not. 0 for all where nothing was found, and for matches that were ignored. Empty where nobody has
  /// computed it, see addProbability().
  std::vector<float> probability;
  std::optional<PoseResult> pose;            ///< of calibrated selectors
  GuessVerdict guess = GuessVerdict::kNone;  ///< of selectors that test Correspondences::guess
  std::string message;                       ///< one sentence for people; empty if there is nothing to report
  std::size_t n_input = 0;                   ///< matches given
  std::size_t n_ignored = 0;  ///< matches with a coordinate that is NaN, infinite or absurd, or without a ray
  std::size_t n_selected = 0;  ///< ones in the mask
  int iterations = 0;          ///< hypotheses, EM steps or passes: the method's own count
  double seconds = 0.0;        ///< wall time of select(), s
};

}  // namespace corrsel::core
