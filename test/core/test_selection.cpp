#include <gtest/gtest.h>

#include "corrsel/selection.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

TEST(Selection, StatusTextsAreFixedAndReadBack) {
  // Numbers and texts are in files and messages: they must not change.
  const std::vector<std::string> texts = {
      "ok",        "too_few",    "degenerate", "no_model", "unsupported_input",
      "too_large", "time_limit", "failed",     "uncertain"};
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_EQ(toString(static_cast<Status>(i)), texts[i]);
    EXPECT_EQ(statusFromString(texts[i]), static_cast<Status>(i));
  }
}

TEST(Selection, RefusesUnknownStatuses) {
  EXPECT_EQ(errorOf<std::invalid_argument>([] { statusFromString("OK"); }),
            "unknown status 'OK'; did you mean 'ok'? valid: ok, too_few, degenerate, no_model, "
            "unsupported_input, too_large, "
            "time_limit, failed, uncertain");
  EXPECT_EQ(errorOf<std::invalid_argument>([] { toString(static_cast<Status>(9)); }), "unknown status 9");
}

TEST(Selection, ModelKindTexts) {
  EXPECT_EQ(toString(ModelKind::kNone), "none");
  EXPECT_EQ(toString(ModelKind::kHomography), "homography");
  EXPECT_EQ(toString(ModelKind::kFundamental), "fundamental");
  EXPECT_EQ(static_cast<int>(ModelKind::kFundamental), 2);
  EXPECT_EQ(toString(ModelKind::kEssential), "essential");
  EXPECT_EQ(toString(ModelKind::kRotation), "rotation");
  EXPECT_EQ(static_cast<int>(ModelKind::kRotation), 4);
  EXPECT_EQ(errorOf<std::invalid_argument>([] { toString(static_cast<ModelKind>(5)); }),
            "unknown model kind 5");
}

TEST(Selection, SceneTextsAreFixedAndReadBack) {
  const std::vector<std::string> texts = {"unknown",           "nothing", "at_rest",
                                          "plane_or_rotation", "rigid",   "several_motions"};
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_EQ(toString(static_cast<SceneKind>(i)), texts[i]);
    EXPECT_EQ(sceneFromString(texts[i]), static_cast<SceneKind>(i));
  }
  EXPECT_EQ(
      errorOf<std::invalid_argument>([] { sceneFromString("rigged"); }).rfind("unknown scene 'rigged'", 0),
      0U);
  EXPECT_EQ(errorOf<std::invalid_argument>([] { toString(static_cast<SceneKind>(6)); }), "unknown scene 6");
}

}  // namespace
}  // namespace corrsel::core
