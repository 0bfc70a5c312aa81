#include "arguments.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <map>
#include <thread>

#include "base/text.h"
#include "corrsel/benchmark/experiments.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/ros/selector_plugins.h"
#include "corrsel/selectors/factory.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

struct Argument {
  const char *name, *default_value, *meaning;
};

constexpr Argument kArguments[] = {
    {"dataset", "",
     "datasets, comma-separated: see --list, or any folder below data_root in one of their layouts; default: "
     "those of the experiment, or sample"},
    {"data_root", "", "folder that holds one folder per dataset, named like the dataset"},
    {"bag", "",
     "bags, comma-separated, instead of datasets: made by make_dataset_bag, or your own (docs/own_bag.md)"},
    {"left", "", "topic of the left images, for bags of your own"},
    {"right", "", "topic of the right images"},
    {"left_info", "", "topic of the left camera_info; default: beside the image topic"},
    {"right_info", "", "topic of the right camera_info; default: beside the image topic"},
    {"ground_truth", "", "topic of corrsel/GroundTruth in the bag; default: /ground_truth"},
    {"correspondences", "",
     "topic of recorded matches, used instead of images; default: found where a bag has no images"},
    {"images", "", "raw, rectified or auto: by the name of the image topic [auto]"},
    {"max_stamp_difference", "", "between the two images of a pair, s [0.01]"},
    {"experiment", "",
     "preset: overall, per_pair, preselected, features, robustness, efficiency, visual, guide, paper"},
    {"features", "", "detector+descriptor combinations, comma-separated, or all [sift+sift,orb+orb]"},
    {"preselection", "", "what reduces the putative matches first: none, nnsr [none,nnsr]"},
    {"selectors", "",
     "selectors, comma-separated, each optionally with a preset (lpm:v2), or all, or package/Class of other "
     "packages [all]"},
    {"options", "", "options, comma-separated: gms.alpha=6,ransac.threshold=3,sift.max_features=2000"},
    {"tolerances", "1,2,3,4,5,6,7,8,9,10", "evaluation tolerances tau, px, comma-separated"},
    {"ground_truth_tolerance", "10", "error up to which a match is a ground-truth inlier, px"},
    {"repetitions", "1", "runs of every selector on every pair, with seeds seed, seed+1..."},
    {"threads", "0", "threads; 0 = all cores. Results do not depend on it, times do"},
    {"seed", "0", "seed of the selectors and of the generated pairs"},
    {"max_pairs", "0", "first pairs of every dataset; 0 = all"},
    {"output_dir", "", "folder of the run; default: a new one under $ROS_HOME/corrsel (~/.ros/corrsel)"},
    {"resume", "false", "continue the run that output_dir holds"},
    {"shard", "", "i/n: run only the i-th of n parts of the pairs; put together with merge"},
    {"merge", "", "run folders, comma-separated, whose pairs are taken over before the run goes on"},
    {"report", "true", "write report.html at the end"},
    {"verbose", "false", "print every judged selection"},
    {"working_dir", "", "folder that relative paths start from; default: the current one"},
};

std::string defaultOutputDir() {
  const char* const ros_home = std::getenv("ROS_HOME");
  const char* const home = std::getenv("HOME");
  const fs::path root =
      ros_home && *ros_home ? fs::path(ros_home) : fs::path(home && *home ? home : ".") / ".ros";
  const std::time_t now = std::time(nullptr);
  char stamp[32];
  std::tm local{};
  std::strftime(stamp, sizeof(stamp), "benchmark_%Y%m%d_%H%M%S", localtime_r(&now, &local));
  fs::path folder = root / "corrsel" / stamp;
  for (int k = 2; fs::exists(folder); ++k)
    folder = root / "corrsel" / (std::string(stamp) + "_" + std::to_string(k));
  return folder.string();
}

/// Command line to values. ROS's own remappings (__name:=...) are left out.
std::map<std::string, std::string> readCommandLine(int argc, char** argv,
                                                   std::vector<std::string>* switches) {
  std::map<std::string, std::string> values;
  for (const Argument& argument : kArguments) values[argument.name] = argument.default_value;
  const auto set = [&values](std::string name, const std::string& value) {
    std::replace(name.begin(), name.end(), '-', '_');
    const auto found = values.find(name);
    if (found == values.end())
      throw UsageError("unknown argument '" + name + "'; --help lists the valid ones");
    found->second = value;
  };
  for (int i = 1; i < argc; ++i) {
    const std::string text = argv[i];
    const std::size_t assignment = text.find(":=");
    if (text.compare(0, 2, "--") == 0) {
      const std::string body = text.substr(2);
      const std::size_t equals = body.find('=');
      if (body == "help" || body == "list" || body == "dry-run") {
        switches->push_back(body);
      } else if (equals != std::string::npos) {
        set(body.substr(0, equals), body.substr(equals + 1));
      } else if (i + 1 < argc) {
        set(body, argv[++i]);
      } else {
        throw UsageError("argument '" + text + "' needs a value");
      }
    } else if (assignment != std::string::npos) {
      if (text.compare(0, 1, "_") != 0) set(text.substr(0, assignment), text.substr(assignment + 2));
    } else {
      throw UsageError("argument '" + text + "' is not understood; --help shows the form");
    }
  }
  return values;
}

using Values = std::map<std::string, std::string>;

std::string absolutePath(const std::string& path, const Values& values) {
  return fs::absolute(fs::path(values.at("working_dir")) / path).lexically_normal().string();
}

std::vector<std::string> absolutePaths(const std::string& list, const Values& values) {
  std::vector<std::string> paths;
  for (const std::string& path : core::splitList(list)) paths.push_back(absolutePath(path, values));
  return paths;
}

/// Datasets of a preset that are below data_root; those that are not are noted. Without data_root the sample
/// set stands in for all.
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
                   ") is a folder below data_root " + data_root + "; see docs/datasets.md");
}

BagTopics bagTopics(const Values& values, core::BenchmarkConfig& config) {
  for (const char* name : {"left", "right", "left_info", "right_info", "ground_truth", "correspondences",
                           "images", "max_stamp_difference"}) {
    if (values.at(name).empty()) continue;
    if (config.bags.empty()) {
      throw UsageError(std::string(name) + " '" + values.at(name) +
                       "' is given without a bag: give bag, too");
    }
    config.bag_topics[name] = values.at(name);
  }
  BagTopics topics;
  topics.left = values.at("left");
  topics.right = values.at("right");
  topics.left_info = values.at("left_info");
  topics.right_info = values.at("right_info");
  topics.ground_truth = values.at("ground_truth");
  topics.correspondences = values.at("correspondences");
  if (!values.at("images").empty()) topics.images = values.at("images");
  if (!values.at("max_stamp_difference").empty()) {
    topics.max_stamp_difference =
        core::parseNumber(values.at("max_stamp_difference"), "max_stamp_difference");
  }
  return topics;
}

void readValues(const Values& values, Arguments& arguments) {
  core::BenchmarkConfig& config = arguments.config;
  const auto text = [&values](const char* name) -> const std::string& { return values.at(name); };
  config.bags = absolutePaths(text("bag"), values);
  config.datasets = core::splitList(text("dataset"));
  if (!config.datasets.empty() && !config.bags.empty()) {
    throw UsageError("both dataset '" + text("dataset") + "' and bag '" + text("bag") +
                     "' are given: leave one");
  }
  config.data_root = text("data_root").empty() ? "" : absolutePath(text("data_root"), values);
  config.features = core::splitList(text("features"));
  config.preselection = core::splitList(text("preselection"));
  config.selectors = core::splitList(text("selectors"));
  core::applyExperiment(text("experiment"), config);
  if (config.datasets.empty() && config.bags.empty()) {
    config.datasets = text("experiment").empty()
                          ? std::vector<std::string>{"sample"}
                          : datasetsOf(text("experiment"), config.data_root, arguments);
  }
  arguments.bag_topics = bagTopics(values, config);
  config.tolerances.clear();
  for (const std::string& tau : core::splitList(text("tolerances"))) {
    config.tolerances.push_back(core::parseNumber(tau, "tolerances"));
  }
  config.ground_truth_tolerance = core::parseNumber(text("ground_truth_tolerance"), "ground_truth_tolerance");
  config.repetitions = core::parseInteger(text("repetitions"), "repetitions");
  config.threads = core::parseInteger(text("threads"), "threads");
  if (config.threads == 0)
    config.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  config.seed = core::parseInteger(text("seed"), "seed");
  config.max_pairs = core::parseInteger(text("max_pairs"), "max_pairs");
  core::parseOptionAssignments(text("options"), config.options);
  config.resolve();

  arguments.shard = core::Shard::fromText(text("shard"));
  arguments.merge = absolutePaths(text("merge"), values);
  arguments.resume = core::parseFlag(text("resume"), "resume");
  arguments.report = core::parseFlag(text("report"), "report");
  arguments.verbose = core::parseFlag(text("verbose"), "verbose");
  if (arguments.resume && text("output_dir").empty())
    throw UsageError("resume needs output_dir: the folder of the run");
  arguments.output_dir =
      text("output_dir").empty() ? defaultOutputDir() : absolutePath(text("output_dir"), values);
}

void printOptions(const std::string& algorithm, const core::OptionSet& options) {
  for (const core::OptionText& option : core::listOptions(options)) {
    std::cout << "      " << algorithm << "." << option.name << " = " << option.value << "  " << option.range
              << (option.unit == "-" ? "" : " " + option.unit) << "  " << option.description << "\n";
  }
}

/// Those that cannot be made are shown with the reason.
void printPlugins() {
  const std::vector<std::string> names = selectorPlugins(), problems = selectorPluginProblems();
  if (names.empty() && problems.empty()) return;
  std::cout << "selectors of other packages:\n";
  for (const std::string& name : names) {
    std::cout << "  " << name << "\n";
    try {
      printOptions(name, core::createSelector(name)->options());
    } catch (const std::invalid_argument& error) {
      std::cout << "      cannot be used: " << error.what() << "\n";
    }
  }
  for (const std::string& problem : problems) std::cout << "  note: " << problem << "\n";
}

}  // namespace

Arguments parseArguments(int argc, char** argv) {
  std::vector<std::string> switches;
  const Values values = readCommandLine(argc, argv, &switches);
  const auto wanted = [&switches](const char* name) {
    return std::find(switches.begin(), switches.end(), name) != switches.end();
  };
  Arguments arguments;
  arguments.help = wanted("help");
  arguments.list = wanted("list");
  arguments.dry_run = wanted("dry-run");
  if (!arguments.help && !arguments.list) readValues(values, arguments);
  return arguments;
}

void printHelp() {
  std::cout
      << "usage: benchmark [--NAME VALUE | --NAME=VALUE | NAME:=VALUE]... [--list] [--dry-run] [--help]\n\n"
         "Compares correspondence selectors on image pairs with ground truth and writes a results folder.\n"
         "Needs no ROS master; where there is one, ~progress and ~score are published.\n\n";
  for (const Argument& argument : kArguments) {
    std::printf("  --%-24s%s%s\n", argument.name, argument.meaning,
                *argument.default_value ? (std::string(" [") + argument.default_value + "]").c_str() : "");
  }
  std::cout
      << "\n  --list                    print datasets, features, selectors with presets, and leave\n"
         "  --dry-run                 check everything, print what would be run, and leave\n\n"
         "exit code: 0 run complete, 1 incomplete (failed pairs, see failures.csv), 2 wrong arguments or\n"
         "unusable data or folder, 130 interrupted (continue with --resume true)\n";
}

void printList() {
  std::cout << "datasets:  " << core::joinList(core::datasetNames())
            << "\nfeatures:  " << core::joinList(core::extractorNames())
            << "\n  or detector+descriptor: detectors " << core::joinList(core::detectorNames())
            << "; descriptors " << core::joinList(core::descriptorNames()) << "\n";
  for (const auto& [name, options] : core::featureAlgorithms()) {
    std::cout << "  " << name << "\n";
    printOptions(name, *options);
  }
  std::cout << "matching:\n";
  printOptions("match", core::MatchOptions());
  std::cout << "selectors:\n";
  for (const std::string& name : core::selectorNames()) {
    std::cout << "  " << name;
    for (const std::string& preset : core::selectorPresets(name)) std::cout << "  " << name << ":" << preset;
    std::cout << "\n";
    printOptions(name, core::createSelector(name)->options());
  }
  printPlugins();
}

}  // namespace corrsel
