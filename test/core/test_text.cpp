#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "base/text.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;
using Texts = std::vector<std::string>;

std::string numberError(const std::string& text) {
  return errorOf<std::invalid_argument>([&text] { parseNumber(text, "x"); });
}

TEST(Text, FormatsTheShortestNumberThatReadsBack) {
  EXPECT_EQ(formatNumber(0), "0");
  EXPECT_EQ(formatNumber(0.1), "0.1");
  EXPECT_EQ(formatNumber(-2.5), "-2.5");
  EXPECT_EQ(formatNumber(1.0 / 3), "0.3333333333333333");
  EXPECT_EQ(formatNumber(0.1 + 0.2), "0.30000000000000004");
  EXPECT_EQ(formatNumber(123456), "123456");
  EXPECT_EQ(formatNumber(1234567), "1234567");
  EXPECT_EQ(formatNumber(std::nan("")), "");
  EXPECT_EQ(formatNumber(INFINITY), "inf");
  EXPECT_EQ(formatNumber(-INFINITY), "-inf");
}

TEST(Text, NumbersSurviveTheRoundTrip) {
  using Limits = std::numeric_limits<double>;
  std::vector<double> values = {
      Limits::max(), Limits::lowest(), Limits::min(), Limits::denorm_min(), Limits::epsilon(), 1e22, -0.0};
  Random random(5);
  for (int i = 0; i < 1000; ++i) {
    const int exponent = int(random.index(600)) - 300;
    values.push_back(std::ldexp(random.uniform(-1, 1), exponent));
  }
  for (const double value : values) {
    const double back = parseNumber(formatNumber(value), "x");
    EXPECT_EQ(back, value) << formatNumber(value);
    EXPECT_EQ(std::signbit(back), std::signbit(value));
  }
  EXPECT_EQ(parseNumber(formatNumber(-INFINITY), "x"), -INFINITY);
}

TEST(Text, ParsesWholeTextsOnly) {
  EXPECT_EQ(parseNumber("1e3", "x"), 1000);
  EXPECT_EQ(parseNumber(" \t-.5\r\n", "x"), -0.5);
  for (const std::string bad : {"", " ", "1 2", "1,5", "abc", "nan", "1e999", "1e-999", "--1", "5px"}) {
    EXPECT_EQ(numberError(bad), "x: '" + bad + "' is not a number");
  }
}

TEST(Text, ParsesIntegers) {
  EXPECT_EQ(parseInteger("-7", "x"), -7);
  EXPECT_EQ(parseInteger("2147483647", "x"), 2147483647);
  EXPECT_EQ(parseInteger("-2147483648", "x"), std::numeric_limits<int>::min());
  EXPECT_EQ(parseInteger("1e3", "x"), 1000);
  for (const std::string bad : {"2147483648", "-2147483649", "0.5", "inf", "-inf"}) {
    EXPECT_EQ(errorOf<std::invalid_argument>([&bad] { parseInteger(bad, "x"); }),
              "x: '" + bad + "' is not a whole number in the range of int");
  }
  EXPECT_TRUE(
      mentions(errorOf<std::invalid_argument>([] { parseInteger("one", "x"); }), {"'one'", "number"}));
}

TEST(Text, ParsesFlags) {
  for (const char* yes : {"true", "True", "1", " true "}) EXPECT_TRUE(parseFlag(yes, "x")) << yes;
  for (const char* no : {"false", "False", "0"}) EXPECT_FALSE(parseFlag(no, "x")) << no;
  for (const std::string bad : {"", "2", "yes", "truefalse"}) {
    EXPECT_EQ(errorOf<std::invalid_argument>([&bad] { parseFlag(bad, "x"); }),
              "x: '" + bad + "' is neither true nor false");
  }
}

TEST(Text, SplitsAndJoinsLists) {
  EXPECT_EQ(splitList("a,b"), (Texts{"a", "b"}));
  EXPECT_EQ(splitList(" a b ,, \tc,"), (Texts{"a b", "c"}));
  EXPECT_EQ(splitList(""), Texts{});
  EXPECT_EQ(splitList(" , "), Texts{});
  EXPECT_EQ(splitList("a,b:c", ':'), (Texts{"a,b", "c"}));
  EXPECT_EQ(joinList({"a", "b", "c"}), "a, b, c");
  EXPECT_EQ(joinList({"a", "b"}, "/"), "a/b");
  EXPECT_EQ(joinList({"a"}), "a");
  EXPECT_EQ(joinList({}), "");
}

TEST(Text, FindsTheNearestName) {
  const Texts selectors = {"nnsr", "ransac", "st",  "gtm",      "usac",
                           "vfc",  "gms",    "lpm", "acransac", "keep_all"};
  const std::pair<const char*, const char*> cases[] = {
      {"gsm", "gms"},           // two neighbours swapped; gtm has one letter replaced
      {"ransack", "ransac"},    // one too many
      {"ranac", "ransac"},      // one left out
      {"lpn", "lpm"},           // one replaced
      {"RANSAC", "ransac"},     // case
      {"keepall", "keep_all"},  // separators
      {"Keep-All", "keep_all"},
      {"acra", "acransac"},  // a beginning
      {"gts", "gtm"},        // gms is equally near and comes later
      {"magic", ""},
      {"homography", ""},
      {"xyz", ""},
      {"", ""},
      {"s", ""},
      {"t", ""},
      {"ke", ""},
  };
  for (const auto& [word, name] : cases) EXPECT_EQ(nearestName(word, selectors), name) << word;
  EXPECT_EQ(nearestName("gms", {}), "");
  EXPECT_EQ(nearestName("v3", {"v1", "v2"}), "");
  // An edit is nearer than a beginning, and the shortest continuation nearer than longer ones.
  EXPECT_EQ(nearestName("lefts", {"lefts_info_topic", "left"}), "left");
  EXPECT_EQ(nearestName("max", {"max_stamp_difference", "max_pairs"}), "max_pairs");
  // A third of the characters may differ, and no more.
  EXPECT_EQ(nearestName("abcdefghi", {"abcdefxyz"}), "abcdefxyz");
  EXPECT_EQ(nearestName("abcdefghi", {"abcdewxyz"}), "");
}

TEST(Text, UnknownNamesAreToldWithTheNearestOne) {
  EXPECT_EQ(didYouMean("gsm", {"lpm", "gms"}), "; did you mean 'gms'?");
  EXPECT_EQ(didYouMean("magic", {"lpm", "gms"}), "");
  EXPECT_EQ(validNames("gsm", {"lpm", "gms"}), "; did you mean 'gms'? valid: lpm, gms");
  EXPECT_EQ(validNames("magic", {"lpm", "gms"}), "; valid: lpm, gms");
  EXPECT_EQ(validNames("v2", {}), "; valid: none");
  EXPECT_EQ(validNames("gsm", {"gms"}, "used"), "; did you mean 'gms'? used: gms");
}

TEST(Text, QuotesCsvFieldsWhereNeeded) {
  EXPECT_EQ(csvField("plain text; 'x'"), "plain text; 'x'");
  EXPECT_EQ(csvField(""), "");
  EXPECT_EQ(csvField("a,b"), "\"a,b\"");
  EXPECT_EQ(csvField("say \"a\""), "\"say \"\"a\"\"\"");
  EXPECT_EQ(csvField("two\nlines"), "\"two lines\"");
  EXPECT_EQ(csvField("two\rlines"), "\"two lines\"");
}

TEST(Text, ParsesCsvLines) {
  EXPECT_EQ(parseCsvLine("a,b,c"), (Texts{"a", "b", "c"}));
  EXPECT_EQ(parseCsvLine("a,,c,\r\n"), (Texts{"a", "", "c", ""}));
  EXPECT_EQ(parseCsvLine(""), Texts{""});
  EXPECT_EQ(parseCsvLine("\"a,b\",\"\"\"\",\"\",d"), (Texts{"a,b", "\"", "", "d"}));
  const Texts fields = {"", "a,b", "\"", "\"\"", "x\",\"y", " blank ", ",", "end"};
  std::string line;
  for (const std::string& field : fields)
    line += (line.empty() && &field == &fields[0] ? "" : ",") + csvField(field);
  EXPECT_EQ(parseCsvLine(line), fields);
}

TEST(Text, MakesFileNamesSafe) {
  EXPECT_EQ(safeFileName("vgg-graf_1.2+x.png"), "vgg-graf_1.2+x.png");
  EXPECT_EQ(safeFileName("../etc/pass wd"), "_._etc_pass_wd");
  EXPECT_EQ(safeFileName(".hidden"), "_hidden");
  EXPECT_EQ(safeFileName("-rf"), "_rf");
  EXPECT_EQ(safeFileName("a:b*c\\d\n$"), "a_b_c_d__");
  EXPECT_EQ(safeFileName("\xc3\xa9"), "__");
  EXPECT_EQ(safeFileName(""), "_");
}

TEST(Text, UniqueFileNamesDiffer) {
  EXPECT_EQ(uniqueFileName("sift+sift_1.2-x"), "sift+sift_1.2-x");
  EXPECT_EQ(uniqueFileName("lpm[lambda=0.5]"), "lpm%5Blambda%3D0.5%5D");
  EXPECT_EQ(uniqueFileName("lpm:v2"), "lpm%3Av2");
  EXPECT_EQ(uniqueFileName("../a b"), "%2E.%2Fa%20b");
  EXPECT_EQ(uniqueFileName("100%"), "100%25");
  EXPECT_EQ(uniqueFileName("\xc3\xa9"), "%C3%A9");
  EXPECT_EQ(uniqueFileName(""), "%");
  const std::string most(200, 'a'), more(201, 'a'), other = std::string(200, 'a') + "b";
  EXPECT_EQ(uniqueFileName(most), most);
  EXPECT_EQ(uniqueFileName(more).size(), 180U + 17U);
  EXPECT_EQ(uniqueFileName(more).substr(0, 181), std::string(180, 'a') + "%");
  EXPECT_NE(uniqueFileName(more), uniqueFileName(other));
}

TEST(Text, CsvLineReadsBack) {
  const std::vector<std::string> fields = {"a,b", "", "say \"x\"", "plain"};
  EXPECT_EQ(csvLine(fields), "\"a,b\",,\"say \"\"x\"\"\",plain");
  EXPECT_EQ(parseCsvLine(csvLine(fields)), fields);
}

TEST(Text, CompleteLinesLeaveOutWhatWasCutOff) {
  EXPECT_EQ(completeLines("a\n\nb\ncut"), (std::vector<std::string>{"a", "", "b"}));
  EXPECT_TRUE(completeLines("cut").empty());
}

TEST(Text, FilesThatCannotBeReadAreEmpty) { EXPECT_EQ(readTextFile("/does/not/exist"), ""); }

}  // namespace
}  // namespace corrsel::core
