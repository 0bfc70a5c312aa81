#pragma once

#include <cstdint>
#include <string>

#include "auto/evidence.h"
#include "corrsel/selection.h"
#include "corrsel/selectors/auto.h"

namespace corrsel::core {

/// What is selected.
enum class Answer : std::uint8_t {
  kNothing,
  kLocal,               ///< the extended local set
  kHomography,          ///< the inliers of the homography
  kHomographyAndMore,   ///< also further planes, and the extended local set
  kFundamental,         ///< the inliers of the fundamental matrix that their surroundings make plausible
  kFundamentalAndMore,  ///< also planes, and the extended local set
};

struct Decision {
  Need need = Need::kNone;  ///< what is missing for a decision; unless kNone, the rest is not valid
  Answer answer = Answer::kNothing;
  Status status = Status::kOk;
  SceneKind scene = SceneKind::kUnknown;
  std::string message;
};

/// Decides what the matches show and which answer to give.
///
/// Algorithm: the first row of a table (decision.cpp) whose conditions hold. A condition whose evidence is
/// missing asks for it, so a row asks from left to right only as long as all its conditions hold.
///
/// A homography counts as `at_rest` if its inliers have a median displacement of at most 1 px. Features are
/// found again with an accuracy of about half a pixel in each image, which gives a median displacement of
/// 0.8 px where nothing moves. A smaller motion cannot be told from that, and gives no depth.
///
/// @param model  to which the user has restricted the answer. The scene is then unknown, because the user has
///               stated the model and nothing has compared it with others.
Decision decide(const Evidence& evidence, AutoOptions::Model model);

}  // namespace corrsel::core
