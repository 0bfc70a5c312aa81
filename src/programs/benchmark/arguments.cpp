#include "programs/benchmark/arguments.h"

#include <algorithm>
#include <cstdio>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <map>

#include "base/text.h"
#include "corrsel/benchmark/experiments.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/selectors/factory.h"
#include "datasets/files.h"
#include "programs/benchmark/argument_table.h"
#include "programs/benchmark/front.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

/// A new folder below that of all runs.
std::string defaultOutputDir(const fs::path& runs) {
  const std::time_t now = std::time(nullptr);
  char stamp[32];
  std::tm local{};
  std::strftime(stamp, sizeof(stamp), "benchmark_%Y%m%d_%H%M%S", localtime_r(&now, &local));
  fs::path folder = runs / stamp;
  for (int k = 2; fs::exists(folder); ++k) folder = runs / (std::string(stamp) + "_" + std::to_string(k));
  return folder.string();
}

using Values = ArgumentValues;

std::string absolutePath(const std::string& path, const Values& values) {
  return fs::absolute(fs::path(values.text("working_dir")) / path).lexically_normal().string();
}

std::vector<std::string> absolutePaths(const std::string& list, const Values& values) {
  std::vector<std::string> paths;
  for (const std::string& path : core::splitList(list)) paths.push_back(absolutePath(path, values));
  return paths;
}

/// Datasets of a preset that exist below data_root; the others are noted. Without data_root, the sample set
/// stands in for all of them.
std::vector<std::string> datasetsOf(const std::string& experiment, const std::string& data_root,
                                    Arguments& arguments) {
  const std::vector<std::string> wanted = core::experimentDatasets(experiment);
  std::vector<std::string> found;
  bool real = false;
  for (const std::string& name : wanted) {
    if (data_root.empty()) {
      arguments.left_out.emplace_back(name, "no data_root is given; the sample set stands in");
      continue;
    }
    const std::string folder = (fs::path(data_root) / name).string();
    if (fs::is_directory(folder)) {
      found.push_back(name);
      real = true;
      continue;
    }
    const bool generated = name == "heinly";
    if (generated) found.push_back("heinly_generated");
    arguments.left_out.emplace_back(
        name, "there is no folder " + folder + (generated ? "; heinly_generated stands in" : ""));
  }
  if (data_root.empty()) return {"sample"};
  if (real) return found;
  throw UsageError("none of the datasets of experiment '" + experiment + "' (" + core::joinList(wanted) +
                   ") is a folder below data_root: " + core::describeDataRoot(data_root) +
                   "; see docs/datasets.md");
}

/// The arguments on the topics of a bag, by name.
std::map<std::string, std::string> bagTopics(const Values& values, const core::BenchmarkConfig& config) {
  std::map<std::string, std::string> topics;
  for (const char* name : {"left", "right", "left_info", "right_info", "ground_truth", "correspondences",
                           "images", "max_stamp_difference"}) {
    if (values.text(name).empty()) continue;
    if (config.bags.empty()) {
      throw UsageError(std::string(name) + " '" + values.text(name) +
                       "' is given without a bag: give bag, too");
    }
    topics[name] = values.text(name);
  }
  if (topics.count("max_stamp_difference") > 0) values.number("max_stamp_difference");  // throws
  return topics;
}

std::vector<std::string> matchForms(const Values& values) {
  const std::vector<std::string> known = {"csv", "npz", "colmap"}, forms = values.list("save_matches");
  for (const std::string& form : forms) {
    if (std::find(known.begin(), known.end(), form) == known.end())
      throw UsageError("save_matches: unknown form '" + form + "'" + core::validNames(form, known));
  }
  return forms;
}

void readValues(const Values& values, const fs::path& runs, Arguments& arguments) {
  core::BenchmarkConfig& config = arguments.config;
  const auto text = [&values](const char* name) -> const std::string& { return values.text(name); };
  config.bags = absolutePaths(text("bag"), values);
  config.datasets = values.list("dataset");
  if (!config.datasets.empty() && !config.bags.empty()) {
    throw UsageError("both dataset '" + text("dataset") + "' and bag '" + text("bag") +
                     "' are given: leave one");
  }
  config.data_root = text("data_root").empty() ? "" : absolutePath(text("data_root"), values);
  config.features = values.list("features");
  config.preselection = values.list("preselection");
  config.selectors = core::splitSelectors(text("selectors"));
  core::applyExperiment(text("experiment"), config);
  if (config.datasets.empty() && config.bags.empty()) {
    config.datasets = text("experiment").empty()
                          ? std::vector<std::string>{"sample"}
                          : datasetsOf(text("experiment"), config.data_root, arguments);
  }
  config.datasets = core::completeDatasets(text("experiment"), config.datasets);
  config.bag_topics = bagTopics(values, config);
  config.tolerances.clear();
  for (const std::string& tau : values.list("tolerances")) {
    config.tolerances.push_back(core::parseNumber(tau, "tolerances"));
  }
  config.ground_truth_tolerance = values.number("ground_truth_tolerance");
  config.repetitions = values.integer("repetitions");
  config.threads = values.integer("threads");
  config.seed = values.integer("seed");
  config.max_pairs = values.integer("max_pairs");
  core::parseOptionAssignments(text("options"), config.options);
  arguments.match_forms = matchForms(values);
  config.save_matches = !arguments.match_forms.empty();
  config.resolve();

  arguments.shard = core::Shard::fromText(text("shard"));
  arguments.merge = absolutePaths(text("merge"), values);
  arguments.resume = values.flag("resume");
  arguments.report = values.flag("report");
  arguments.verbose = values.flag("verbose");
  arguments.dry_run = values.flag("dry_run");
  if (arguments.resume && text("output_dir").empty())
    throw UsageError("resume needs output_dir: the folder of the run");
  arguments.output_dir =
      text("output_dir").empty() ? defaultOutputDir(runs) : absolutePath(text("output_dir"), values);
}

void printOptions(const std::string& algorithm, const core::OptionSet& options) {
  for (const core::OptionText& option : core::listOptions(options)) {
    std::cout << "      " << algorithm << "." << option.name << " = " << option.value << "  " << option.range
              << (option.unit == "-" ? "" : " " + option.unit) << "  " << option.description << "\n";
  }
}

/// One line of the overview.
void printSelectorLine(const std::string& name, const std::string& text) {
  constexpr std::size_t kWidth = 12;
  std::cout << "    " << name << std::string(name.size() < kWidth ? kWidth - name.size() : 0, ' ')
            << (text.empty() ? "" : " ") << text << "\n";
}

void printGroup(core::SelectorGroup group) {
  std::cout << "  " << core::toString(group) << " (" << core::meaningOf(group) << ")\n";
}

/// Prints one line for each selector, below the name of its group. Selectors of other packages that cannot be
/// created are printed with the reason.
/// @return those that can be used
std::vector<core::SelectorFactory> printSelectors(const BenchmarkFront& front) {
  std::vector<core::SelectorFactory> usable = core::builtInSelectors();
  std::cout << "selectors:\n";
  for (std::size_t i = 0; i < usable.size(); ++i) {
    if (i == 0 || usable[i].group() != usable[i - 1].group()) printGroup(usable[i].group());
    printSelectorLine(usable[i].name(), usable[i].meaning());
  }
  const std::vector<std::string> names = front.selectorPlugins(), problems = front.selectorPluginProblems();
  if (!names.empty() || !problems.empty()) printGroup(core::SelectorGroup::kOtherPackage);
  for (const std::string& name : names) {
    try {
      const core::SelectorFactory selector = core::findSelector(name);
      selector.create();
      printSelectorLine(name, selector.meaning());
      usable.push_back(selector);
    } catch (const std::invalid_argument& error) {
      printSelectorLine(name, std::string(" cannot be used: ") + error.what());
    }
  }
  for (const std::string& problem : problems) std::cout << "    note: " << problem << "\n";
  return usable;
}

void printSelectorOptions(const core::SelectorFactory& selector) {
  std::cout << "  " << selector.name();
  for (const auto& preset : selector.presets()) std::cout << "  " << selector.name() << ":" << preset.first;
  std::cout << "\n";
  printOptions(selector.name(), selector.create()->options());
}

}  // namespace

Arguments parseArguments(const std::vector<std::string>& words, const BenchmarkFront& front) {
  const Values values = parseCommandLine(benchmarkArguments(), words);
  Arguments arguments;
  arguments.help = values.help;
  if (arguments.help) return arguments;
  arguments.list = values.isOn("list");
  if (!arguments.list) readValues(values, front.runsFolder(), arguments);
  return arguments;
}

void printList(const BenchmarkFront& front) {
  std::cout << "datasets:  " << core::joinList(core::datasetNames())
            << "\nfeatures:  " << core::joinList(core::extractorNames())
            << "\n  or detector+descriptor: detectors " << core::joinList(core::detectorNames())
            << "; descriptors " << core::joinList(core::descriptorNames()) << "\n";
  for (const auto& [name, reason] : core::missingAlgorithms()) std::cout << "  missing: " << reason << "\n";
  const std::vector<core::SelectorFactory> selectors = printSelectors(front);
  std::cout << "options of the features:\n";
  for (const auto& [name, options] : core::featureAlgorithms()) {
    std::cout << "  " << name << "\n";
    printOptions(name, *options);
  }
  std::cout << "options of matching:\n";
  printOptions("match", core::MatchOptions());
  std::cout << "presets and options of the selectors:\n";
  for (const core::SelectorFactory& selector : selectors) printSelectorOptions(selector);
}

}  // namespace corrsel
