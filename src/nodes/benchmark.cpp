// The benchmark node: reads dataset bags in its own process, runs the grid, leaves a results folder. Works
// with and without a ROS master; see --help.

#include <ros/master.h>
#include <ros/package.h>
#include <ros/ros.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "corrsel/Progress.h"
#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/runner.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/datasets/sample.h"
#include "corrsel/features/extractor.h"
#include "corrsel/features/matcher.h"
#include "corrsel/ros/bag_cache.h"
#include "corrsel/ros/conversions.h"
#include "corrsel/ros/dataset_bag.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/text.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

constexpr int kExitComplete = 0, kExitIncomplete = 1, kExitUsage = 2, kExitInterrupted = 130;

std::atomic<bool> stop_requested{false};

void requestStop(int signal) {
  stop_requested = true;
  // A second Ctrl-C ends the process at once.
  std::signal(signal, SIG_DFL);
}

struct Argument {
  const char *name, *default_value, *meaning;
};

constexpr Argument kArguments[] = {
    {"dataset", "",
     "datasets, comma-separated: sample, vgg, symbench, adelaidermf; default sample unless bags are given"},
    {"data_root", "", "folder that holds one folder per dataset, named like the dataset"},
    {"bag", "", "dataset bags (comma-separated) made by make_dataset_bag, instead of datasets"},
    {"features", "sift+sift,orb+orb", "detector+descriptor combinations, comma-separated, or all"},
    {"preselection", "none,nnsr", "what reduces the putative matches first: none, nnsr"},
    {"selectors", "all", "selectors, comma-separated, each optionally with a preset (lpm:v2), or all"},
    {"options", "", "options, comma-separated: gms.alpha=6,ransac.threshold=3,sift.max_features=2000"},
    {"tolerances", "1,2,3,4,5,6,7,8,9,10", "evaluation tolerances tau, px, comma-separated"},
    {"ground_truth_tolerance", "10", "error up to which a match is a ground-truth inlier, px"},
    {"repetitions", "1", "runs of every selector on every pair, with seeds seed, seed+1..."},
    {"threads", "0", "threads; 0 = all cores. Results do not depend on it, times do"},
    {"seed", "0", "seed of the selectors and of the generated pairs"},
    {"max_pairs", "0", "first pairs of every dataset; 0 = all"},
    {"output_dir", "", "folder of the run; default: a new one under $ROS_HOME/corrsel (~/.ros/corrsel)"},
    {"resume", "false", "continue the run that output_dir holds"},
    {"report", "true", "write report.html at the end"},
    {"verbose", "false", "print every judged selection"},
    {"working_dir", "", "folder that relative paths start from; default: the current one"},
};

class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

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

void printOptions(const std::string& algorithm, const core::OptionSet& options) {
  for (const core::OptionText& option : core::listOptions(options)) {
    std::cout << "      " << algorithm << "." << option.name << " = " << option.value << "  " << option.range
              << (option.unit == "-" ? "" : " " + option.unit) << "  " << option.description << "\n";
  }
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
}

/// Command line to values. ROS's own remappings (__name:=...) are left out.
std::map<std::string, std::string> parseArguments(int argc, char** argv, std::vector<std::string>* switches) {
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

std::string absolutePath(const std::string& path, const std::string& working_dir) {
  return fs::absolute(fs::path(working_dir) / path).lexically_normal().string();
}

core::BenchmarkConfig configFrom(std::map<std::string, std::string>& values) {
  core::BenchmarkConfig config;
  config.bags = core::splitList(values["bag"]);
  if (values["dataset"].empty() && config.bags.empty()) values["dataset"] = "sample";
  config.datasets = core::splitList(values["dataset"]);
  if (!config.datasets.empty() && !config.bags.empty()) {
    throw UsageError("both dataset '" + values["dataset"] + "' and bag '" + values["bag"] +
                     "' are given: leave one");
  }
  const std::string& working_dir = values["working_dir"];
  config.data_root = values["data_root"].empty() ? "" : absolutePath(values["data_root"], working_dir);
  for (std::string& bag : config.bags) bag = absolutePath(bag, working_dir);
  config.features = core::splitList(values["features"]);
  config.preselection = core::splitList(values["preselection"]);
  config.selectors = core::splitList(values["selectors"]);
  config.tolerances.clear();
  for (const std::string& tau : core::splitList(values["tolerances"])) {
    config.tolerances.push_back(core::parseNumber(tau, "tolerances"));
  }
  config.ground_truth_tolerance =
      core::parseNumber(values["ground_truth_tolerance"], "ground_truth_tolerance");
  config.repetitions = core::parseInteger(values["repetitions"], "repetitions");
  config.threads = core::parseInteger(values["threads"], "threads");
  if (config.threads == 0)
    config.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  config.seed = core::parseInteger(values["seed"], "seed");
  config.max_pairs = core::parseInteger(values["max_pairs"], "max_pairs");
  core::parseOptionAssignments(values["options"], config.options);
  config.resolve();
  return config;
}

/// Runs a program of this package with one argument and waits for it. @return its exit code, 127 if not found
int runScript(const std::string& name, const std::string& argument) {
  std::error_code error;
  const fs::path here = fs::read_symlink("/proc/self/exe", error).parent_path();
  std::vector<fs::path> candidates = {here / name};
  const std::string package = ros::package::getPath("corrsel");
  if (!package.empty()) candidates.insert(candidates.begin(), fs::path(package) / "scripts" / name);
  for (const fs::path& candidate : candidates) {
    if (!fs::exists(candidate)) continue;
    std::cout.flush();
    const pid_t child = fork();
    if (child < 0) return 127;
    if (child == 0) {
      // The system's Python: another one may come first in PATH and lack the packages.
      const char* const path = std::getenv("PATH");
      setenv("PATH", ("/usr/bin:/bin:" + std::string(path ? path : "")).c_str(), 1);
      execl(candidate.c_str(), candidate.c_str(), argument.c_str(), static_cast<char*>(nullptr));
      _exit(127);
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
  }
  return 127;
}

/// Folder of a dataset: below data_root; the sample set lives in the cache unless data_root has it.
std::string datasetFolder(const std::string& name, const std::string& data_root) {
  const fs::path below = fs::path(data_root) / name;
  if (name == "sample" && (data_root.empty() || !fs::is_directory(below))) {
    return (fs::path(cacheFolder()) / "sample").string();
  }
  if (data_root.empty()) {
    throw UsageError("dataset '" + name + "' needs data_root: the folder that holds the folder '" + name +
                     "'");
  }
  return below.string();
}

void fetchSamplesIfMissing(const std::string& folder) {
  for (const std::string& image : core::SampleReader::imageNames()) {
    if (fs::exists(fs::path(folder) / image)) continue;
    std::cout << "fetching the sample photographs (Debian's opencv-doc, once, 96 MB)..." << std::endl;
    if (runScript("fetch_samples.sh", folder) != 0) {
      throw core::DatasetError("the sample photographs are missing in " + folder +
                               " and could not be fetched; run: rosrun corrsel fetch_samples.sh");
    }
    return;
  }
}

std::string defaultOutputDir() {
  const char* const ros_home = std::getenv("ROS_HOME");
  const char* const home = std::getenv("HOME");
  const fs::path root =
      ros_home && *ros_home ? fs::path(ros_home) : fs::path(home && *home ? home : ".") / ".ros";
  const std::time_t now = std::time(nullptr);
  char stamp[32];
  std::tm local{};
  std::strftime(stamp, sizeof(stamp), "benchmark_%Y%m%d_%H%M%S", localtime_r(&now, &local));
  return (root / "corrsel" / stamp).string();
}

/// Shows the run to people and publishes it where a master is there.
class Reporter : public core::RunObserver {
 public:
  Reporter(bool verbose, const std::string& output_dir)
      : printer_(std::cout, isatty(STDOUT_FILENO) != 0), verbose_(verbose), output_dir_(output_dir) {
    if (!ros::isInitialized() || !ros::master::check()) return;
    node_.emplace("~");
    progress_publisher_ = node_->advertise<Progress>("progress", 10, true);
    score_publisher_ = node_->advertise<Score>("score", 1000);
  }

  void progress(const core::Progress& progress) override {
    last_ = progress;
    printer_.show(progress);
    publish("running");
  }

  void judged(const std::vector<core::ResultRow>& rows) override {
    const core::ResultRow& first = rows.front();
    if (verbose_) {
      printer_.finish();
      std::cout << first.id.text() << " " << first.features << " " << first.preselection << " "
                << first.selector << ": " << first.n_selected << " of " << first.n_putative << " selected, "
                << toString(first.status) << std::endl;
    }
    if (!node_) return;
    core::Evaluation evaluation;
    evaluation.n_putative = first.n_putative;
    evaluation.n_ground_truth = first.n_ground_truth;
    evaluation.n_selected = first.n_selected;
    for (const core::ResultRow& row : rows) evaluation.metrics.push_back(row.metrics);
    ScoreLabels labels;
    labels.pair.header.stamp = ros::Time(ros::WallTime::now().toSec());
    labels.pair.id = first.id;
    labels.pair.features = first.features;
    labels.preselection = first.preselection;
    labels.selector = first.selector;
    labels.status = first.status;
    labels.select_seconds = first.select_seconds;
    score_publisher_.publish(toMsg(evaluation, labels));
  }

  void failed(const core::Failure& failure) override {
    printer_.finish();
    std::cerr << "failed (" << failure.stage
              << "): " << (failure.id.dataset.empty() ? "" : failure.id.text() + ": ") << failure.error
              << std::endl;
  }

  void finish(const std::string& state) {
    printer_.finish();
    publish(state);
  }

 private:
  void publish(const std::string& state) {
    if (!node_) return;
    Progress message;
    message.header.stamp = ros::Time(ros::WallTime::now().toSec());
    message.state = state;
    message.current = last_.current;
    message.pairs_done = static_cast<std::uint32_t>(last_.done);
    message.pairs_total = static_cast<std::uint32_t>(last_.total);
    message.rate = last_.rate;
    message.remaining_seconds = last_.remaining;
    message.output_dir = output_dir_;
    progress_publisher_.publish(message);
  }

  core::ProgressPrinter printer_;
  bool verbose_;
  std::string output_dir_;
  core::Progress last_;
  std::optional<ros::NodeHandle> node_;
  ros::Publisher progress_publisher_, score_publisher_;
};

/// The tolerance shown in tables: the paper's 5 px where it is evaluated, else the largest.
double tableTolerance(const core::BenchmarkConfig& config) {
  const auto& taus = config.tolerances;
  return std::find(taus.begin(), taus.end(), 5.0) != taus.end() ? 5.0
                                                                : *std::max_element(taus.begin(), taus.end());
}

std::string percent(double value) {
  char text[16];
  std::snprintf(text, sizeof(text), "%6.1f", 100 * value);
  return std::isnan(value) ? "     -" : text;
}

void printTable(const std::vector<core::SummaryRow>& summary, double tau) {
  std::string heading;
  for (const core::SummaryRow& row : summary) {
    if (!std::isnan(row.tau) && row.tau != tau) continue;
    const std::string group = row.dataset + ", " + row.features + ", preselection " + row.preselection;
    if (group != heading) {
      heading = group;
      std::cout << "\n"
                << group << (std::isnan(row.tau) ? "" : ", tau = " + core::formatNumber(tau) + " px") << "\n";
      std::printf("  %-18s %5s %6s %6s %6s   %-14s %10s %10s\n", "selector", "pairs", "P %", "R %", "F %",
                  "95 % of F", "median ms", "p95 ms");
    }
    if (row.pairs == 0 && std::isnan(row.select_median)) {
      std::printf("  %-18s %5s  unsupported input\n", row.selector.c_str(), "-");
      continue;
    }
    std::printf("  %-18s %5zu %s %s %s   %s..%s %10.3f %10.3f\n", row.selector.c_str(), row.pairs,
                percent(row.precision).c_str(), percent(row.recall_paper).c_str(),
                percent(row.f_paper).c_str(), percent(row.f_low).c_str(), percent(row.f_high).c_str(),
                1e3 * row.select_median, 1e3 * row.select_p95);
  }
  std::cout << std::endl;
}

int run(int argc, char** argv) {
  std::vector<std::string> switches;
  std::map<std::string, std::string> values = parseArguments(argc, argv, &switches);
  const auto wanted = [&switches](const char* name) {
    return std::find(switches.begin(), switches.end(), name) != switches.end();
  };
  if (wanted("help")) {
    printHelp();
    return kExitComplete;
  }
  if (wanted("list")) {
    printList();
    return kExitComplete;
  }
  const core::BenchmarkConfig config = configFrom(values);
  const bool resume = core::parseFlag(values["resume"], "resume"),
             report = core::parseFlag(values["report"], "report");
  const bool verbose = core::parseFlag(values["verbose"], "verbose");
  if (resume && values["output_dir"].empty())
    throw UsageError("resume needs output_dir: the folder of the run");
  const std::string output_dir = values["output_dir"].empty()
                                     ? defaultOutputDir()
                                     : absolutePath(values["output_dir"], values["working_dir"]);

  std::map<std::string, std::unique_ptr<core::DatasetReader>> readers;
  for (const std::string& name : config.datasets) {
    const std::vector<std::string> valid = core::datasetNames();
    if (std::find(valid.begin(), valid.end(), name) == valid.end()) {
      throw UsageError("unknown dataset '" + name + "'; valid: " + core::joinList(valid));
    }
    const std::string folder = datasetFolder(name, config.data_root);
    if (name == "sample") fetchSamplesIfMissing(folder);
    readers[name] = core::openDataset(name, folder, config.seed);
  }
  if (wanted("dry-run")) {
    std::cout << config.toYaml() << "output_dir: " << output_dir << "\n";
    for (const auto& [name, reader] : readers) std::cout << name << ": " << reader->size() << " pairs\n";
    for (const std::string& bag : config.bags)
      std::cout << bag << ": " << BagSource(bag).size() << " pairs\n";
    return kExitComplete;
  }

  core::RunFolder folder(output_dir, config, resume);
  std::cout << "results folder: " << output_dir << std::endl;
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  Reporter reporter(verbose, output_dir);
  std::size_t broken = 0;
  std::vector<std::unique_ptr<core::PairSource>> sources;
  for (const std::string& name : config.datasets) {
    core::ProgressPrinter printer(std::cout, isatty(STDOUT_FILENO) != 0);
    const core::ProgressMeter meter(readers[name]->size(), 0);
    const CachedBag bag =
        cachedDatasetBag((fs::path(cacheFolder()) / "bags").string(), name, *readers[name], config.seed,
                         [&](std::size_t done, std::size_t, const core::PairId& id) {
                           printer.show(meter.at(done, "writing the bag of " + id.text()));
                         });
    printer.finish();
    std::cout << (bag.reused ? "using " : "made ") << bag.path << std::endl;
    for (const std::string& problem : bag.problems) {
      const core::Failure failure{{name, "", ""}, "", "read", problem};
      folder.appendFailure(failure);
      reporter.failed(failure);
      ++broken;
    }
    if (bag.problems.size() < readers[name]->size()) sources.push_back(std::make_unique<BagSource>(bag.path));
  }
  for (const std::string& bag : config.bags) {
    std::cout << "opening " << bag << std::endl;
    sources.push_back(std::make_unique<BagSource>(bag));
  }

  core::BenchmarkRunner runner(config, folder, reporter, stop_requested);
  core::RunState state = runner.run(sources);
  state.pairs_total += broken;
  state.pairs_failed += broken;
  reporter.finish(state.interrupted ? "interrupted" : state.complete() ? "finished" : "failed");
  const std::vector<core::SummaryRow> summary = folder.writeSummary(state);
  printTable(summary, tableTolerance(config));
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::cout << state.pairs_done << " of " << state.pairs_total << " pairs done, " << state.pairs_failed
            << " failed; peak memory " << usage.ru_maxrss / 1024 << " MiB\n";
  if (state.interrupted)
    std::cout << "interrupted: continue with resume:=true output_dir:=" << output_dir << "\n";
  bool reported = true;
  if (report) {
    reported = runScript("report.py", output_dir) == 0;
    if (!reported) std::cerr << "report.html could not be written: the message above says why" << std::endl;
  }
  std::cout << "results: " << output_dir << std::endl;
  if (state.interrupted) return kExitInterrupted;
  return state.complete() && reported ? kExitComplete : kExitIncomplete;
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  // ROS takes its remappings out of its own copy; names like dataset:=vgg are this program's arguments.
  std::vector<char*> ros_argv;
  for (int i = 0; i < argc; ++i) {
    if (i == 0 || std::string(argv[i]).compare(0, 2, "__") == 0) ros_argv.push_back(argv[i]);
  }
  int ros_argc = static_cast<int>(ros_argv.size());
  try {
    ros::init(ros_argc, ros_argv.data(), "benchmark", ros::init_options::NoSigintHandler);
    return corrsel::run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "benchmark: " << error.what() << std::endl;
  }
  return corrsel::kExitUsage;
}
