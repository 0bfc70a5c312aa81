#include <gtest/gtest.h>

#include <cmath>

#include "corrsel/options.h"
#include "test_support.h"

namespace corrsel::core {
namespace {

using namespace testing;

struct Sample : OptionSet {
  double size = 0.1;
  int count = 3;
  bool quick = true;
  enum class Mode { kOne, kTwo };
  Mode mode = Mode::kOne;
  std::string note;

  void visit(OptionVisitor& visitor) const override {
    visitor.number({"size", 0.1, 2.5, "px", "How large"}, &Sample::size);
    visitor.integer({"count", 1, 9, "-", "How many"}, &Sample::count);
    visitor.flag("quick", "Whether quick", &Sample::quick);
    visitor.choice("mode", {{Mode::kOne, "one", "The first"}, {Mode::kTwo, "two", "The second"}}, "Which",
                   &Sample::mode);
    visitor.text("note", "Anything", &Sample::note);
  }
};

std::string refusal(const OptionMap& values) {
  return errorOf<std::invalid_argument>([&values] {
    Sample options;
    setOptions(options, values, "thing");
  });
}

TEST(Options, AreListedInOrderOfDeclaration) {
  Sample options;
  options.quick = false;
  const std::vector<OptionText> rows = listOptions(options);
  ASSERT_EQ(rows.size(), 5u);
  const std::vector<std::vector<std::string>> expected = {
      {"size", "0.1", "[0.1, 2.5]", "px", "How large"},
      {"count", "3", "[1, 9]", "-", "How many"},
      {"quick", "false", "true, false", "-", "Whether quick"},
      {"mode", "one", "one, two", "-", "Which"},
      {"note", "", "text", "-", "Anything"},
  };
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const OptionText& r = rows[i];
    EXPECT_EQ((std::vector<std::string>{r.name, r.value, r.range, r.unit, r.description}), expected[i]);
  }
}

TEST(Options, ListedValuesReadBackIdentically) {
  for (const double value : {0.1 + 0.2, 1.0 / 3, std::nextafter(1.0, 2.0), 2.5}) {
    Sample written, read;
    written.size = value;
    OptionMap values;
    for (const OptionText& row : listOptions(written)) values[row.name] = row.value;
    setOptions(read, values, "thing");
    EXPECT_EQ(read.size, value);
  }
}

TEST(Options, AreSetByName) {
  Sample options;
  setOptions(options,
             {{"size", " 2.5 "}, {"count", "1"}, {"quick", "false"}, {"mode", "two"}, {"note", " x"}},
             "thing");
  EXPECT_EQ(options.size, 2.5);
  EXPECT_EQ(options.count, 1);
  EXPECT_FALSE(options.quick);
  EXPECT_EQ(options.mode, Sample::Mode::kTwo);
  EXPECT_EQ(options.note, " x");
  setOptions(options, {{"count", "9"}}, "thing");
  EXPECT_EQ(options.count, 9);
  EXPECT_EQ(options.mode, Sample::Mode::kTwo);
  EXPECT_NO_THROW(options.check());
}

TEST(Options, AreDescribedWithTypeRangeAndMeaning) {
  const Sample options;
  const std::vector<OptionField> fields = optionFields(options);
  ASSERT_EQ(fields.size(), 5u);
  const std::vector<std::string> types = {"number", "integer", "flag", "choice", "text"};
  for (std::size_t i = 0; i < fields.size(); ++i) EXPECT_EQ(toString(fields[i].type), types[i]);
  EXPECT_EQ(fields[0].min, 0.1);
  EXPECT_EQ(fields[0].max, 2.5);
  EXPECT_EQ(fields[0].unit, "px");
  EXPECT_EQ(fields[1].get(options), OptionValue(3));
  EXPECT_EQ(fields[2].get(options), OptionValue(true));
  ASSERT_EQ(fields[3].choices.size(), 2u);
  EXPECT_EQ(fields[3].choices[1].name, "two");
  EXPECT_EQ(fields[3].choices[1].meaning, "The second");
}

TEST(Options, RefusesUnknownNamesAndUnreadableValues) {
  EXPECT_TRUE(mentions(refusal({{"colour", "red"}}), {"thing.colour", "valid: size"}));
  EXPECT_TRUE(mentions(refusal({{"size", "big"}}), {"'big'", "thing.size"}));
  EXPECT_TRUE(mentions(refusal({{"size", ""}}), {"''", "thing.size"}));
  EXPECT_TRUE(mentions(refusal({{"count", "1.5"}}), {"'1.5'", "thing.count"}));
  EXPECT_TRUE(mentions(refusal({{"quick", "maybe"}}), {"'maybe'", "thing.quick"}));
  EXPECT_TRUE(mentions(refusal({{"mode", "three"}}), {"'three'", "thing.mode"}));
  struct None : OptionSet {
    void visit(OptionVisitor&) const override {}
  } none;
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&none] {
                         setOptions(none, {{"a", "1"}}, "none");
                       }),
                       {"none.a", "valid: none"}));
}

TEST(Options, SkipsUnknownNamesOnlyWhereAsked) {
  Sample options;
  setOptionsWherePresent(options, {{"colour", "red"}, {"count", "7"}}, "thing");
  EXPECT_EQ(options.count, 7);
  EXPECT_TRUE(mentions(errorOf<std::invalid_argument>([&options] {
                         setOptionsWherePresent(options, {{"count", "x"}}, "thing");
                       }),
                       {"'x'", "thing.count"}));
}

TEST(Options, CheckNamesOptionValueAndRange) {
  const auto complaint = [](double size, int count, Sample::Mode mode) {
    Sample options;
    options.size = size;
    options.count = count;
    options.mode = mode;
    return errorOf<std::invalid_argument>([&options] { options.check(); });
  };
  // Both ends belong to the range.
  EXPECT_EQ(complaint(0.1, 1, Sample::Mode::kOne), "");
  EXPECT_EQ(complaint(2.5, 9, Sample::Mode::kTwo), "");
  EXPECT_EQ(complaint(std::nextafter(0.1, 0), 3, Sample::Mode::kOne),
            "option size = 0.09999999999999999 is outside [0.1, 2.5]");
  EXPECT_EQ(complaint(2.75, 3, Sample::Mode::kOne), "option size = 2.75 is outside [0.1, 2.5]");
  EXPECT_EQ(complaint(std::nan(""), 3, Sample::Mode::kOne), "option size =  is outside [0.1, 2.5]");
  EXPECT_EQ(complaint(INFINITY, 3, Sample::Mode::kOne), "option size = inf is outside [0.1, 2.5]");
  EXPECT_EQ(complaint(1, 0, Sample::Mode::kOne), "option count = 0 is outside [1, 9]");
  EXPECT_EQ(complaint(1, 10, Sample::Mode::kOne), "option count = 10 is outside [1, 9]");
  EXPECT_EQ(complaint(1, 3, Sample::Mode{7}), "option mode = '7' is not one of one, two");
}

}  // namespace
}  // namespace corrsel::core
