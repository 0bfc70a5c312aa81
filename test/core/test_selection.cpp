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
  EXPECT_EQ(errorOf<std::invalid_argument>([] { toString(static_cast<ModelKind>(3)); }),
            "unknown model kind 3");
}

}  // namespace
}  // namespace corrsel::core
