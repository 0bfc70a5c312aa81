#include "auto/decision.h"

#include <array>
#include <cstddef>
#include <optional>

#include "search/significance.h"

namespace corrsel::core {
namespace {

constexpr double kMaxDisplacementAtRest = 1;  // px, see decide()

constexpr std::size_t kConditions = 12;

/// Conditions are one letter each, blanks aside: y = yes, n = no, . = either.
struct Row {
  const char* conditions;
  Answer answer;
  SceneKind scene;
  const char* message;
  Status status = Status::kOk;
};

constexpr char kPlane[] = "a plane or a camera that only turns";
constexpr char kSurroundings[] = "matches that agree with their surroundings";

// Homography: found, significant, leaves a coherent group over, leaves many single matches over, parallax.
// Fundamental matrix: found, significant, explains half of the single matches, leaves a coherent group over.
// Local support: significant, more than the homography, any.
constexpr Row kAnyModel[] = {
    {".ynnn .... ...", Answer::kHomography, SceneKind::kPlaneOrRotation, kPlane},
    {".ynyn ..n. ...", Answer::kHomography, SceneKind::kPlaneOrRotation,
     "a plane; local matches are imprecise"},
    {"..... .y.n ...", Answer::kFundamental, SceneKind::kRigid, "epipolar geometry of a rigid scene"},
    {"..... .y.y ...", Answer::kFundamentalAndMore, SceneKind::kSeveralMotions,
     "several motions; the fundamental matrix holds for one of them"},
    {".yy.. .... y..", Answer::kHomographyAndMore, SceneKind::kSeveralMotions,
     "several motions; the homography holds for one of them"},
    {".y... .... ...", Answer::kHomography, SceneKind::kPlaneOrRotation, kPlane},
    {"..... .... .yn", Answer::kLocal, SceneKind::kNothing, "nothing agrees more than by chance",
     Status::kNoModel},
    {"..... .... yy.", Answer::kLocal, SceneKind::kUnknown, kSurroundings},
    {"..... .... .y.", Answer::kLocal, SceneKind::kNothing, kSurroundings},
    {"..... .... ...", Answer::kHomography, SceneKind::kNothing, kPlane},
};
constexpr Row kHomographyOnly[] = {
    {"y.... .... ...", Answer::kHomography, SceneKind::kUnknown, kPlane},
    {"..... .... ...", Answer::kNothing, SceneKind::kUnknown, "no homography was found", Status::kNoModel},
};
constexpr Row kFundamentalOnly[] = {
    {"..... y... ...", Answer::kFundamental, SceneKind::kUnknown, "epipolar geometry of a rigid scene"},
    {"..... .... ...", Answer::kNothing, SceneKind::kUnknown, "no fundamental matrix was found",
     Status::kNoModel},
};

constexpr Need kNeeds[kConditions] = {Need::kNone,
                                      Need::kNone,
                                      Need::kHomographyLeftover,
                                      Need::kHomographyLeftover,
                                      Need::kParallax,
                                      Need::kFundamental,
                                      Need::kFundamental,
                                      Need::kFundamental,
                                      Need::kFundamentalLeftover,
                                      Need::kLocalConfidence,
                                      Need::kLocalConfidence,
                                      Need::kNone};

using Facts = std::array<std::optional<bool>, kConditions>;

bool isAtRest(const Evidence& e) { return e.homography.displacement <= kMaxDisplacementAtRest; }

/// The facts in the order of the conditions; those that are not known yet are empty.
Facts factsOf(const Evidence& e) {
  Facts facts;
  facts[0] = e.homography.found;
  facts[1] = isSignificant(e.homography.confidence);
  if (e.homography_leftover) {
    facts[2] = e.homography_leftover->coherent;
    facts[3] = e.homography_leftover->loose;
  }
  facts[4] = isAtRest(e) ? std::optional(false) : e.parallax;
  if (e.fundamental) {
    facts[5] = e.fundamental->found;
    facts[6] = isSignificant(e.fundamental->confidence);
    facts[7] = *facts[6] && e.fundamental->explains_loose;
  }
  facts[8] = e.fundamental_leftover;
  if (e.local_confidence) {
    facts[9] = isSignificant(*e.local_confidence);
    facts[10] = !e.homography.found || *e.local_confidence > e.homography.confidence;
  }
  facts[11] = e.local_support;
  return facts;
}

/// Whether the conditions of a row hold; empty if that is not known, and `need` then receives what is
/// missing.
std::optional<bool> holds(const Row& row, const Facts& facts, Need& need) {
  std::size_t i = 0;
  for (const char* condition = row.conditions; *condition != '\0'; ++condition) {
    if (*condition == ' ') continue;
    const std::optional<bool>& fact = facts[i];
    const Need missing = kNeeds[i++];
    if (*condition == '.') continue;
    if (!fact) {
      need = missing;
      return std::nullopt;
    }
    if (*fact != (*condition == 'y')) return false;
  }
  return true;
}

template <std::size_t N>
Decision decideBy(const Row (&rows)[N], const Evidence& evidence) {
  const Facts facts = factsOf(evidence);
  Decision decision;
  for (const Row& row : rows) {
    const std::optional<bool> chosen = holds(row, facts, decision.need);
    if (!chosen) break;
    if (!*chosen) continue;
    decision.answer = row.answer;
    decision.status = row.status;
    decision.scene = row.scene;
    decision.message = row.message;
    if (row.scene == SceneKind::kPlaneOrRotation && isAtRest(evidence)) decision.scene = SceneKind::kAtRest;
    break;
  }
  return decision;
}

}  // namespace

Decision decide(const Evidence& evidence, AutoOptions::Model model) {
  switch (model) {
    case AutoOptions::Model::kHomography:
      return decideBy(kHomographyOnly, evidence);
    case AutoOptions::Model::kFundamental:
      return decideBy(kFundamentalOnly, evidence);
    case AutoOptions::Model::kAuto:
      break;
  }
  return decideBy(kAnyModel, evidence);
}

}  // namespace corrsel::core
