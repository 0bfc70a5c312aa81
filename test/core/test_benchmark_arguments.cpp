#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "base/text.h"
#include "programs/benchmark/argument_table.h"
#include "test_paths.h"
#include "test_support.h"

namespace corrsel {
namespace {

using core::testing::contains;

/// Whether a launch file passes the argument on: switches make the program exit, and the launch file itself
/// decides where relative paths start.
bool isLaunched(const Argument& argument) {
  return !argument.value.empty() && argument.name != "working_dir";
}

std::string readSource(const std::string& file) {
  const std::string text = core::readTextFile(corrsel::testing::sourceDir() + "/" + file);
  EXPECT_FALSE(text.empty()) << file;
  return text;
}

std::string escaped(std::string text) {
  text = std::regex_replace(text, std::regex("&"), "&amp;");
  return std::regex_replace(text, std::regex("\""), "&quot;");
}

/// The part of a text from `begin` to `end`, both left out.
std::string between(const std::string& text, const std::string& begin, const std::string& end) {
  const std::size_t first = text.find(begin);
  if (first == std::string::npos) return "";
  const std::size_t start = first + begin.size();
  return text.substr(start, text.find(end, start) - start);
}

TEST(BenchmarkArguments, LaunchFileHasThemAll) {
  const std::string launch = readSource("launch/benchmark.launch");
  std::string declared;
  for (const Argument& argument : benchmarkArguments().arguments) {
    if (!isLaunched(argument)) continue;
    declared += "  <arg name=\"" + argument.name + "\" default=\"" + argument.default_value + "\" doc=\"" +
                escaped(argument.meaning) + "\"/>\n";
    const std::string passed = "--" + argument.name + "='$(arg " + argument.name + ")'";
    EXPECT_TRUE(contains(launch, passed)) << "launch/benchmark.launch does not pass on " << passed;
  }
  EXPECT_EQ(between(launch, "<launch>\n", "\n  <!--"), declared)
      << "launch/benchmark.launch must declare these arguments:\n"
      << declared;
}

TEST(BenchmarkArguments, DocumentationHasTheirDefaults) {
  const std::string docs = between(readSource("docs/benchmark.md"), "## Arguments\n", "\n## ");
  for (const Argument& argument : benchmarkArguments().arguments) {
    if (!isLaunched(argument)) continue;
    EXPECT_TRUE(contains(docs, "`" + argument.name + "`")) << argument.name;
    if (argument.default_value.empty()) continue;
    const std::string row = "| `" + argument.name + "` | `" + argument.default_value + "` |";
    EXPECT_TRUE(contains(docs, row)) << "docs/benchmark.md lacks " << row;
  }
}

}  // namespace
}  // namespace corrsel
