#include <gtest/gtest.h>

#include "corrsel/selectors/factory.h"
#include "corrsel/selectors/selector_spec.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using testing::contains;
using testing::errorOf;
using testing::mentions;
using Names = std::vector<std::string>;

TEST(SelectorSpec, TakesATextApart) {
  SelectorSpec spec = SelectorSpec::fromText("gms");
  EXPECT_EQ(spec.name, "gms");
  EXPECT_FALSE(spec.preset);
  EXPECT_TRUE(spec.options.empty());
  spec = SelectorSpec::fromText("usac:h[max_seconds=0.01]");
  EXPECT_EQ(spec.name, "usac");
  EXPECT_EQ(spec.preset, "h");
  EXPECT_EQ(spec.options, (OptionMap{{"max_seconds", "0.01"}}));
  spec = SelectorSpec::fromText("package/Class:fast[b = 1e+5 ; a=x:y]");
  EXPECT_EQ(spec.name, "package/Class");
  EXPECT_EQ(spec.preset, "fast");
  EXPECT_EQ(spec.options, (OptionMap{{"a", "x:y"}, {"b", "1e+5"}}));
  EXPECT_EQ(spec.text(), "package/Class:fast[a=x:y;b=1e+5]");
  EXPECT_EQ(SelectorSpec::fromText("lpm:").preset, "") << "createSelector() refuses it";
  for (const char* text : {"gms", "lpm:v2", "lpm:v2[k=5]", "gms[alpha=6;grid=10]"}) {
    EXPECT_EQ(SelectorSpec::fromText(text).text(), text);
  }
}

TEST(SelectorSpec, NamesWhatIsWrongWithTheBrackets) {
  const std::pair<const char*, const char*> cases[] = {
      {"gms[alpha=6", "']' is missing"},
      {"gms]", "']' stands without '['"},
      {"gms]alpha=6[", "something follows the first ']'"},
      {"gms[alpha=6]:scale", "something follows the first ']'"},
      {"gms[alpha=6][grid=3]", "something follows the first ']'"},
      {"gms[]", "the brackets are empty"},
      {"gms[;]", "the brackets are empty"},
      {"gms[alpha]", "'alpha' is not an option with its value"},
      {"gms[alpha=]", "'alpha=' is not an option with its value"},
      {"gms[=6]", "'=6' is not an option with its value"},
      {"gms[alpha=6=7]", "'alpha=6=7' is not an option with its value"},
      {"gms[alpha=6,grid=3]", "'alpha=6,grid=3' contains a comma"},
      {"gms[alpha=6;alpha=7]", "option alpha is given twice"},
  };
  for (const auto& [text, fault] : cases) {
    EXPECT_EQ(errorOf<std::invalid_argument>([&text = text] { SelectorSpec::fromText(text); }),
              "selector '" + std::string(text) + "': " + fault +
                  "; options in brackets read name[option=value;option=value]");
  }
}

TEST(SelectorSpec, CommasInBracketsDoNotSeparate) {
  EXPECT_EQ(splitSelectors("gms, lpm:v2[k=5;lambda_first=1] ,,usac[max_seconds=0.01]"),
            (Names{"gms", "lpm:v2[k=5;lambda_first=1]", "usac[max_seconds=0.01]"}));
  EXPECT_EQ(splitSelectors("gms[alpha=6,grid=3],lpm"), (Names{"gms[alpha=6,grid=3]", "lpm"}));
  EXPECT_EQ(splitSelectors("gms[alpha=6,lpm"), (Names{"gms[alpha=6,lpm"}));
  EXPECT_EQ(splitSelectors(" "), Names{});
}

TEST(SelectorSpec, OptionsInBracketsWinOverAllOthers) {
  const auto value = [](const std::string& spec, const OptionMap& options, const OptionMap& common) {
    const std::unique_ptr<Selector> selector = createSelector(spec, options, common);
    for (const OptionText& option : listOptions(selector->options())) {
      if (option.name == "threshold") return option.value;
    }
    return std::string("none");
  };
  EXPECT_EQ(value("ransac", {}, {{"threshold", "1"}}), "1");
  EXPECT_EQ(value("nnsr:lowe", {}, {}), "none");
  EXPECT_EQ(value("st:leordeanu_hebert", {}, {{"threshold", "0.1"}}), "-1");
  EXPECT_EQ(value("st:leordeanu_hebert", {{"threshold", "0.2"}}, {{"threshold", "0.1"}}), "0.2");
  EXPECT_EQ(value("st:leordeanu_hebert[threshold=0.4]", {{"threshold", "0.2"}}, {{"threshold", "0.1"}}),
            "0.4");
}

TEST(SelectorSpec, ErrorsNameTheTextTheOptionAndWhatIsValid) {
  const auto refusal = [](const std::string& spec) {
    return errorOf<std::invalid_argument>([&spec] { createSelector(spec); });
  };
  std::string error = refusal("gms[alpa=6]");
  EXPECT_TRUE(contains(error, "selector 'gms[alpa=6]': unknown option gms.alpa; did you mean 'alpha'?"))
      << error;
  EXPECT_TRUE(mentions(refusal("gms[alpha=-1]"), {"alpha = -1", "'gms[alpha=-1]'", "[0, 100]"}));
  EXPECT_TRUE(mentions(refusal("gms[grid=many]"), {"'gms[grid=many]'", "'many'", "gms.grid"}));
  error = refusal("gsm[alpha=6]");
  EXPECT_TRUE(contains(error, "selector 'gsm[alpha=6]': unknown selector 'gsm'; did you mean 'gms'?"))
      << error;
  error = refusal("lpm:v3[k=5]");
  EXPECT_TRUE(contains(error, "selector 'lpm:v3[k=5]': unknown preset 'v3'")) << error;
}

}  // namespace
}  // namespace corrsel::core
