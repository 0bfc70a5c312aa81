// Compares two run folders and reports what became better, what became worse and what is within noise. It
// needs no ROS.

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include "base/text.h"
#include "corrsel/benchmark/comparison.h"
#include "programs/command_line.h"

namespace {

namespace core = corrsel::core;

constexpr int kNothingWorse = 0, kWorse = 1, kUnusable = 2;
/// Lines of a list that are printed without --all.
constexpr std::size_t kShownLines = 10;

struct Arguments {
  std::string before, after;
  core::ComparisonOptions options;
  bool strict = false, all = false;
};

corrsel::CommandLineTable argumentTable() {
  const core::ComparisonOptions defaults;
  return {
      "compare_runs",
      "Compares two runs of the benchmark pair by pair and reports what became better or worse. BEFORE and "
      "AFTER "
      "are the output folders of the runs.",
      {"BEFORE", "AFTER"},
      {
          {"tau", "PX", core::formatNumber(defaults.tau),
           "tolerance that is compared; labelled pairs have none and are always compared"},
          {"metric", "NAME", defaults.metric, core::joinList(core::comparisonMetrics())},
          {"tolerance", "X", core::formatNumber(defaults.tolerance),
           "mean differences up to this are ignored, in units of the metric"},
          {"strict", "", "",
           "fail also where a mean moved by more than the tolerance in either direction, significantly or "
           "not, "
           "and where only AFTER has a value"},
          {"all", "", "", "list all groups, not only those that changed"},
      },
      "A group is one selector on one dataset with one kind of features and preselection. A group is worse "
      "or\n"
      "better where the 95 % paired bootstrap interval of the mean difference does not contain 0 and the\n"
      "difference exceeds the tolerance. Otherwise it is within noise, within tolerance, or equal (every "
      "pair).\n"
      "\n"
      "exit code: 0 = nothing became worse, 1 = something did, or AFTER lacks values of BEFORE, 2 = wrong "
      "arguments\n"
      "or a run folder that cannot be used (the message names the file, the line and the remedy)\n"};
}

/// Throws corrsel::UsageError.
Arguments argumentsOf(const corrsel::ArgumentValues& values) {
  Arguments arguments;
  arguments.before = values.text("BEFORE");
  arguments.after = values.text("AFTER");
  arguments.options.tau = values.number("tau");
  arguments.options.metric = values.text("metric");
  arguments.options.tolerance = values.number("tolerance");
  arguments.strict = values.isOn("strict");
  arguments.all = values.isOn("all");
  return arguments;
}

/// A list of lines under a heading, cut short without `all`.
void printList(const std::string& heading, const std::vector<std::string>& lines, bool all) {
  if (lines.empty()) return;
  std::cout << "\n" << heading << "\n";
  const std::size_t shown = all ? lines.size() : std::min(lines.size(), kShownLines);
  for (std::size_t i = 0; i < shown; ++i) std::cout << "  " << lines[i] << "\n";
  if (shown < lines.size()) {
    std::cout << "  and " << lines.size() - shown << " more (--all lists them)\n";
  }
}

/// Worse ones first, the worst of them at the top; then better ones, then those that moved within noise.
bool comesFirst(const core::GroupComparison& a, const core::GroupComparison& b) {
  const auto rank = [](const core::GroupComparison& g) {
    switch (g.verdict) {
      case core::Verdict::kWorse:
        return 0;
      case core::Verdict::kBetter:
        return 1;
      case core::Verdict::kWithinNoise:
        return g.beyond_tolerance ? 2 : 3;
      case core::Verdict::kWithinTolerance:
        return 4;
      case core::Verdict::kEqual:
        break;
    }
    return 5;
  };
  if (rank(a) != rank(b)) return rank(a) < rank(b);
  return rank(a) < 5 && std::abs(a.difference) > std::abs(b.difference);
}

void printGroups(const std::vector<core::GroupComparison>& groups, bool strict) {
  if (groups.empty()) return;
  std::size_t width = 5;
  const auto name = [](const core::GroupComparison& g) {
    return g.dataset + ", " + g.features + ", " + g.preselection + ", " + g.selector;
  };
  for (const core::GroupComparison& g : groups) width = std::max(width, name(g).size());
  std::printf("\n%-*s %5s  %6s  %6s  %-26s %6s  verdict\n", static_cast<int>(width), "group", "pairs",
              "before", "after", "difference [95 %]", "time");
  bool few = false;
  for (const core::GroupComparison& g : groups) {
    char ratio[16] = "-";
    if (!std::isnan(g.time_ratio)) std::snprintf(ratio, sizeof(ratio), "x%.2f", g.time_ratio);
    std::string verdict = toString(g.verdict);
    if (strict && g.beyond_tolerance && g.verdict == core::Verdict::kWithinNoise) {
      verdict += ", beyond tolerance";
    }
    const bool narrow = g.pairs < core::kFewPairs && g.verdict != core::Verdict::kEqual;
    few = few || narrow;
    std::printf("%-*s %5zu  %6.4f  %6.4f  %+7.4f [%+7.4f, %+7.4f] %6s  %s%s\n", static_cast<int>(width),
                name(g).c_str(), g.pairs, g.before, g.after, g.difference, g.interval.low, g.interval.high,
                ratio, verdict.c_str(), narrow ? " *" : "");
  }
  if (few) {
    std::printf("* fewer than %zu pairs: the interval is too narrow to tell a change from chance\n",
                core::kFewPairs);
  }
}

std::vector<std::string> textsOf(const std::vector<core::UnmatchedValue>& values) {
  std::vector<std::string> texts;
  for (const core::UnmatchedValue& value : values) texts.push_back(value.text());
  return texts;
}

int run(const Arguments& arguments) {
  const core::ComparisonOptions& options = arguments.options;
  const core::RecordedRun before = core::readRun(arguments.before), after = core::readRun(arguments.after);
  const core::RunComparison result = core::compareRuns(before, after, options);
  std::cout << "before: " << before.folder << "\nafter:  " << after.folder << "\n"
            << options.metric
            << (core::hasTolerances(options.metric) ? " at tau = " + core::formatNumber(options.tau) + " px"
                                                    : "")
            << ", tolerance " << core::formatNumber(options.tolerance) << (arguments.strict ? ", strict" : "")
            << "\n";
  printList("the configurations differ (for information):", result.config_differences, arguments.all);
  printList("missing in AFTER:", textsOf(result.lost), arguments.all);
  printList("only in AFTER:", textsOf(result.added), arguments.all);

  std::vector<core::GroupComparison> groups = result.groups;
  std::stable_sort(groups.begin(), groups.end(), comesFirst);
  const auto unchanged = [&](const core::GroupComparison& g) {
    const bool moved = g.verdict == core::Verdict::kWorse || g.verdict == core::Verdict::kBetter ||
                       (arguments.strict && g.beyond_tolerance);
    return !moved;
  };
  if (!arguments.all) groups.erase(std::remove_if(groups.begin(), groups.end(), unchanged), groups.end());
  printGroups(groups, arguments.strict);

  std::cout << "\n" << result.groups.size() << " groups:";
  const char* separator = " ";
  for (const core::Verdict verdict :
       {core::Verdict::kWorse, core::Verdict::kBetter, core::Verdict::kWithinNoise,
        core::Verdict::kWithinTolerance, core::Verdict::kEqual}) {
    std::cout << separator << result.count(verdict) << " " << toString(verdict);
    separator = ", ";
  }
  std::cout << (arguments.all || groups.size() == result.groups.size() ? "" : " (--all lists them)") << "\n";
  if (result.expectedByChance() > 0) {
    std::printf(
        "Of the %zu groups that differ, %.1f would be called better or worse by chance alone "
        "(5 %% each, not corrected).\n",
        result.groups.size() - result.count(core::Verdict::kEqual), result.expectedByChance());
  }
  const bool passed = result.passes(arguments.strict);
  std::cout << (passed ? "passed" : "failed") << ": " << result.count(core::Verdict::kWorse) << " worse, "
            << result.lost.size() << " missing";
  if (arguments.strict) {
    const auto moved = std::count_if(result.groups.begin(), result.groups.end(),
                                     [](const core::GroupComparison& g) { return g.beyond_tolerance; });
    std::cout << ", " << moved << " moved beyond the tolerance, " << result.added.size() << " added";
  }
  std::cout << std::endl;
  return passed ? kNothingWorse : kWorse;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const corrsel::CommandLineTable table = argumentTable();
    const corrsel::ArgumentValues values = corrsel::parseCommandLine(table, {argv + 1, argv + argc});
    if (values.help) {
      std::cout << corrsel::helpText(table);
      return kNothingWorse;
    }
    return run(argumentsOf(values));
  } catch (const std::exception& error) {
    std::cerr << "compare_runs: " << error.what() << std::endl;
  }
  return kUnusable;
}
