#include <gtest/gtest.h>

#include <sstream>

#include "programs/command_line.h"
#include "test_support.h"

namespace corrsel {
namespace {

using core::testing::contains;
using core::testing::errorOf;
using core::testing::mentions;

const CommandLineTable kTable = {"program",
                                 "Does something.",
                                 {},
                                 {{"data_root", "FOLDER", "", "where the data are"},
                                  {"rate", "HZ", "10", "pairs per second"},
                                  {"max-ratio", "R", "1", "largest ratio"},
                                  {"resume", "BOOL", "false", "continue"},
                                  {"strict", "", "", "fail early"}},
                                 "exit code: 0 = ok\n"};

CommandLineTable withPositional() {
  CommandLineTable table = kTable;
  table.positional = {"BEFORE", "AFTER"};
  return table;
}

TEST(CommandLine, ReadsEveryForm) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--data_root", "/d", "--rate", "2.5", "--max-ratio", "-0.5", "--strict"},
        std::vector<std::string>{"--strict", "--data-root=/d", "--rate=2.5", "--max_ratio=-0.5"},
        std::vector<std::string>{"data_root:=/d", "rate:=2.5", "max_ratio:=-0.5", "--strict"}}) {
    const ArgumentValues values = parseCommandLine(kTable, words);
    EXPECT_EQ(values.text("data_root"), "/d");
    EXPECT_EQ(values.number("rate"), 2.5);
    EXPECT_EQ(values.number("max-ratio"), -0.5);
    EXPECT_TRUE(values.isOn("strict"));
    EXPECT_TRUE(values.given("rate") && !values.given("resume"));
    EXPECT_FALSE(values.flag("resume"));
    EXPECT_FALSE(values.help);
  }
}

TEST(CommandLine, DefaultsAreThoseOfTheTable) {
  const ArgumentValues values = parseCommandLine(kTable, {});
  EXPECT_EQ(values.text("data_root"), "");
  EXPECT_EQ(values.integer("rate"), 10);
  EXPECT_FALSE(values.isOn("strict") || values.given("rate"));
}

TEST(CommandLine, ValuesMayHoldSeparators) {
  EXPECT_EQ(parseCommandLine(kTable, {"data_root:=a=b:=c"}).text("data_root"), "a=b:=c");
  EXPECT_EQ(parseCommandLine(kTable, {"--data_root=x=y:=z"}).text("data_root"), "x=y:=z");
  EXPECT_EQ(parseCommandLine(kTable, {"data_root:=a, b,"}).list("data_root"),
            (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(parseCommandLine(kTable, {"--data_root="}).text("data_root"), "");
}

TEST(CommandLine, FlagsAreTrueWithoutAValue) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--resume"}, std::vector<std::string>{"--resume", "--rate", "3"},
        std::vector<std::string>{"--resume", "rate:=3"}, std::vector<std::string>{"--resume", "true"}}) {
    EXPECT_TRUE(parseCommandLine(kTable, words).flag("resume"));
  }
  EXPECT_FALSE(parseCommandLine(kTable, {"--resume", "false"}).flag("resume"));
}

TEST(CommandLine, NamesOfRoslaunchAreSkipped) {
  EXPECT_EQ(parseCommandLine(kTable, {"__name:=x", "_parameter:=y", "__log:=/z"}).text("data_root"), "");
}

TEST(CommandLine, UnknownArgumentsAreNamedWithTheValidOnes) {
  for (const char* word : {"--no-such", "--no-such=1", "no_such:=1", "-x", "word"}) {
    const std::string error = errorOf<UsageError>([&] { parseCommandLine(kTable, {word}); });
    EXPECT_TRUE(contains(error, std::string("'") + word + "'") && contains(error, "--max-ratio")) << error;
  }
  std::vector<std::string> rest;
  parseCommandLine(kTable, {"--strict", "--other=1", "-x"}, &rest);
  EXPECT_EQ(rest, (std::vector<std::string>{"--other=1", "-x"}));
}

TEST(CommandLine, TheNearestNameIsNamed) {
  const std::string valid = " valid: --data_root, --rate, --max-ratio, --resume, --strict, --help";
  const std::pair<const char*, const char*> cases[] = {
      {"dataroot:=/d", "--data_root"},   {"--dataroot", "--data_root"}, {"--dataroot=/d", "--data_root"},
      {"--max_ration=1", "--max-ratio"}, {"-rate", "--rate"},           {"--hepl", "--help"},
      {"--max", "--max-ratio"},
  };
  for (const auto& [word, name] : cases) {
    EXPECT_EQ(errorOf<UsageError>([word = word] { parseCommandLine(kTable, {word}); }),
              std::string("unknown argument '") + word + "'; did you mean '" + name + "'?" + valid);
  }
  EXPECT_EQ(errorOf<UsageError>([] { parseCommandLine(kTable, {"nonsense:=1"}); }),
            "unknown argument 'nonsense:=1';" + valid);
}

TEST(CommandLine, ArgumentsAreGivenOnce) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"--rate", "1", "--rate", "2"},
        std::vector<std::string>{"rate:=1", "--rate=2"},
        std::vector<std::string>{"--rate=1", "--strict", "rate:=2"}}) {
    EXPECT_TRUE(
        mentions(errorOf<UsageError>([&] { parseCommandLine(kTable, words); }), {"--rate", "'1'", "'2'"}));
  }
  // The same value twice is probably a mistake of a script, and '-' is '_'.
  EXPECT_TRUE(mentions(errorOf<UsageError>([] {
                         parseCommandLine(kTable, {"max_ratio:=1", "--max-ratio=1"});
                       }),
                       {"--max-ratio", "'1'"}));
  EXPECT_TRUE(mentions(errorOf<UsageError>([] {
                         parseCommandLine(kTable, {"--strict", "--strict"});
                       }),
                       {"--strict", "given", "twice"}));
}

TEST(CommandLine, WrongValuesAreNamed) {
  EXPECT_TRUE(
      contains(errorOf<UsageError>([] { parseCommandLine(kTable, {"--rate"}); }), "--rate needs a value"));
  EXPECT_TRUE(
      contains(errorOf<UsageError>([] { parseCommandLine(kTable, {"--strict=1"}); }), "takes no value"));
  const ArgumentValues values =
      parseCommandLine(kTable, {"--rate", "fast", "--max-ratio", "3", "--resume", "maybe"});
  const std::string number = errorOf<UsageError>([&] { values.number("rate"); });
  EXPECT_TRUE(contains(number, "--rate") && contains(number, "'fast'")) << number;
  const std::string range = errorOf<UsageError>([&] { values.number("max-ratio", 0, 1); });
  EXPECT_TRUE(contains(range, "--max-ratio must be between 0 and 1, not 3")) << range;
  EXPECT_TRUE(contains(errorOf<UsageError>([&] { values.flag("resume"); }), "--resume: 'maybe'"));
  EXPECT_TRUE(contains(errorOf<UsageError>([&] { values.integer("rate"); }), "--rate: 'fast'"));
  const std::string whole = errorOf<UsageError>([&] { values.integer("max-ratio", 4, 7); });
  EXPECT_EQ(whole, "--max-ratio must be between 4 and 7, not 3");
  EXPECT_EQ(values.integer("max-ratio", 3, 3), 3);
  EXPECT_TRUE(contains(errorOf<UsageError>([&] {
                         values.choice("rate", {"slow", "fst"});
                       }),
                       "not 'fast'; did you mean 'fst'?"));
  EXPECT_TRUE(contains(errorOf<UsageError>([&] {
                         values.choice("rate", {"a", "b"});
                       }),
                       "one of a, b, not 'fast'"));
}

TEST(CommandLine, PositionalArgumentsAreCounted) {
  const ArgumentValues values = parseCommandLine(withPositional(), {"a", "--rate", "3", "b"});
  EXPECT_EQ(values.text("BEFORE"), "a");
  EXPECT_EQ(values.text("AFTER"), "b");
  const std::string few = errorOf<UsageError>([] { parseCommandLine(withPositional(), {"a"}); });
  EXPECT_TRUE(contains(few, "BEFORE, AFTER") && contains(few, "1 given")) << few;
  EXPECT_TRUE(contains(errorOf<UsageError>([] {
                         parseCommandLine(withPositional(), {"a", "b", "c"});
                       }),
                       "'c'"));
}

TEST(CommandLine, HelpNamesEverythingAndFitsTheScreen) {
  EXPECT_TRUE(parseCommandLine(withPositional(), {"-h"}).help);
  EXPECT_TRUE(parseCommandLine(kTable, {"--rate", "3", "--help", "--no-such"}).help);
  CommandLineTable table = withPositional();
  table.arguments[0].meaning = std::string(60, 'x') + " " + std::string(60, 'y');
  const std::string text = helpText(table);
  for (const char* part : {"usage: program BEFORE AFTER", "Does something.", "--data_root FOLDER",
                           "--strict ", "pairs per second [10]", "--help", "exit code: 0 = ok"}) {
    EXPECT_TRUE(contains(text, part)) << part << " in\n" << text;
  }
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 110U) << line;
}

}  // namespace
}  // namespace corrsel
