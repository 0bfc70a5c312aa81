// The benchmark node. It reads bags in its own process, runs the grid and writes a results folder. It works
// with and without a ROS master; see --help.

#include <ros/package.h>
#include <ros/ros.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/stopwatch.h"
#include "base/text.h"
#include "corrsel/benchmark/runner.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/ros/selector_plugins.h"
#include "datasets/sample.h"
#include "programs/benchmark/argument_table.h"
#include "programs/benchmark/arguments.h"
#include "programs/benchmark/dry_run.h"
#include "programs/benchmark/node_name.h"
#include "programs/benchmark/reporter.h"
#include "ros/bags/bag_cache.h"
#include "ros/bags/open_bag.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

using Readers = std::map<std::string, std::unique_ptr<core::DatasetReader>>;
using Sources = std::vector<std::unique_ptr<core::PairSource>>;

constexpr int kExitComplete = 0, kExitIncomplete = 1, kExitUsage = 2, kExitInterrupted = 130;

std::atomic<bool> stop_requested{false};

void requestStop(int signal) {
  stop_requested = true;
  // A second Ctrl-C ends the process at once.
  std::signal(signal, SIG_DFL);
}

/// Runs a program of this package and waits for it. @return its exit code, 127 if not found
int runScript(const std::string& name, const std::vector<std::string>& arguments) {
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
      // The report calls programs that lie beside this one.
      setenv("PATH", ("/usr/bin:/bin:" + here.string() + ":" + std::string(path ? path : "")).c_str(), 1);
      std::vector<std::string> words = arguments;
      words.insert(words.begin(), candidate.string());
      std::vector<char*> argv;
      for (std::string& word : words) argv.push_back(word.data());
      argv.push_back(nullptr);
      execv(candidate.c_str(), argv.data());
      _exit(127);
    }
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : 127;
  }
  return 127;
}

/// Folder of a dataset below data_root. Datasets that are made from the sample photographs use the folder of
/// the sample set, which is in the cache unless data_root has it.
std::string datasetFolder(const std::string& name, const std::string& data_root) {
  if (core::needsSamplePhotographs(name)) {
    const fs::path below = fs::path(data_root) / "sample";
    return data_root.empty() || !fs::is_directory(below) ? (fs::path(cacheFolder()) / "sample").string()
                                                         : below.string();
  }
  if (data_root.empty()) {
    throw UsageError("dataset '" + name + "' needs data_root: the folder that holds the folder '" +
                     core::imageDataset(name) + "'");
  }
  return (fs::path(data_root) / core::imageDataset(name)).string();
}

/// @param fetch  whether photographs that are missing are fetched; otherwise they are an error
void requireSamples(const std::string& folder, bool fetch) {
  constexpr char kFetch[] = "rosrun corrsel fetch_samples.sh";
  for (const std::string& image : core::SampleReader::imageNames()) {
    if (fs::exists(fs::path(folder) / image)) continue;
    const std::string missing = "the sample photographs are missing in " + folder;
    if (!fetch) throw core::DatasetError(missing + "; a run fetches them, and so does: " + kFetch);
    std::cout << "fetching the sample photographs (Debian's opencv-doc, once, 96 MB)..." << std::endl;
    if (runScript("fetch_samples.sh", {folder}) != 0) {
      throw core::DatasetError(missing + " and could not be fetched; run: " + kFetch);
    }
    return;
  }
}

std::unique_ptr<core::DatasetReader> openDataset(const std::string& name, const core::BenchmarkConfig& config,
                                                 bool fetch) {
  const std::string folder = datasetFolder(name, config.data_root);
  if (core::needsSamplePhotographs(name)) requireSamples(folder, fetch);
  return core::openDataset(name, folder, config.seed);
}

Readers openDatasets(const core::BenchmarkConfig& config) {
  Readers readers;
  for (const std::string& name : config.datasets) readers[name] = openDataset(name, config, true);
  return readers;
}

/// The bags of the datasets. Bags that the cache lacks are made. Pairs that cannot be read are recorded.
/// @param broken  the number of pairs that could not be read is added to it
std::vector<std::string> datasetBags(const core::BenchmarkConfig& config, const Readers& readers,
                                     core::RunFolder& folder, Reporter& reporter, std::size_t* broken) {
  std::vector<std::string> bags;
  for (const std::string& name : config.datasets) {
    const core::Stopwatch watch;
    const core::DatasetReader& reader = *readers.at(name);
    const core::ProgressMeter meter(reader.size(), 0);
    const CachedBag bag =
        cachedDatasetBag((fs::path(cacheFolder()) / "bags").string(), name, reader, config.seed,
                         [&](std::size_t done, std::size_t, const core::PairId& id) {
                           reporter.progress(meter.at(done, "writing the bag of " + id.text()));
                         });
    reporter.endLine();
    std::cout << (bag.reused ? "using " : "made ") << bag.path << std::endl;
    if (!bag.reused) folder.appendStage({"bag", watch.seconds()}, name);
    for (const std::string& remark : bag.remarks) {
      folder.appendRemark({name, "", "", remark});
      reporter.noticed({name, "", "", remark});
    }
    for (const UnreadablePair& problem : bag.problems) {
      const core::Failure failure{problem.id, "", "read", problem.error};
      folder.appendFailure(failure);
      reporter.failed(failure);
      ++*broken;
    }
    if (bag.problems.size() < reader.size()) bags.push_back(bag.path);
  }
  return bags;
}

/// @param remarks  what the readers decided and left out is added to it, where it is not null
Sources openBags(const std::vector<std::string>& bags, const Arguments& arguments,
                 std::vector<core::Remark>* remarks = nullptr) {
  Sources sources;
  for (const std::string& bag : bags) {
    std::unique_ptr<BagSource> source = openBag(bag, arguments.bag_topics);
    std::vector<std::string> notes = source->notes();
    if (!source->judgedByCalibration().empty()) {
      std::vector<std::string> tolerances;
      for (const double tau : arguments.config.tolerances) tolerances.push_back(core::formatNumber(tau));
      notes.push_back(
          source->judgedByCalibration() + " (tolerances " + core::joinList(tolerances, ", ") +
          " px; inliers within " + core::formatNumber(arguments.config.ground_truth_tolerance) +
          " px): a wrong match near its epipolar line counts as correct, so precision is an upper "
          "bound");
    }
    for (const std::string& note : notes) {
      if (remarks != nullptr) remarks->push_back({fs::path(bag).stem().string(), "", "", note});
    }
    sources.push_back(std::move(source));
  }
  return sources;
}

/// Runs the grid, and then the stages that need its results. @return the state at the end
core::RunState runStages(const Arguments& arguments, const std::vector<std::string>& bags,
                         const Sources& sources, core::RunFolder& folder, Reporter& reporter) {
  const core::BenchmarkConfig& config = arguments.config;
  core::BenchmarkRunner runner(config, folder, reporter, stop_requested);
  core::RunState state = runner.run(sources, arguments.shard);
  reporter.endLine();
  // A part of a run does not have the results that example pairs are chosen from, and selectors are timed
  // only once.
  if (arguments.shard.count == 1 && !stop_requested) {
    runner.timeSelectors();
    reporter.endLine();
  }
  if (arguments.shard.count == 1 && !stop_requested) {
    runner.drawExamples(openBags(bags, arguments));
    reporter.endLine();
  }
  state.interrupted = stop_requested;
  state.left_out_datasets = arguments.left_out;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.peak_memory_mib = static_cast<double>(usage.ru_maxrss / 1024);
  return state;
}

/// Prints the winners, and with `verbose` the tables of all selectors, prints the guide where the experiment
/// has one, and writes the report. One program makes them all, so that the terminal and the report show the
/// same numbers.
/// @return whether everything could be made
bool reportResults(const Arguments& arguments) {
  std::vector<std::string> words = {arguments.output_dir};
  if (arguments.verbose) words.insert(words.begin(), "--all");
  if (!arguments.report) words.insert(words.begin(), "--no-page");
  std::cout << std::endl;
  if (runScript("report.py", words) != 0) {
    std::cerr << "the results could not be printed, or report.html could not be written: see the message "
                 "above; the means are in "
              << arguments.output_dir << "/summary.csv" << std::endl;
    return false;
  }
  if (!arguments.verbose) {
    std::cout << "All selectors and tolerances are in summary.csv; verbose:=true prints them, and so does\n"
              << "  rosrun corrsel report.py --all --no-page " << arguments.output_dir << "\n";
  }
  return true;
}

/// Converts the saved matches of a run, which are CSV files, to the other forms that are wanted.
/// @return the forms that could not be made
std::vector<std::string> convertMatches(const std::vector<std::string>& forms, const std::string& run) {
  std::vector<std::string> failed;
  for (const std::string& form : forms) {
    if (form != "csv" && runScript("export_matches.py", {"--format", form, run}) != 0) failed.push_back(form);
  }
  return failed;
}

/// The parts of a run are converted once they have been merged. @return whether all forms could be made
bool exportMatches(const Arguments& arguments) {
  if (arguments.match_forms.empty()) return true;
  const std::string folder = (fs::path(arguments.output_dir) / "matches").string();
  std::cout << "matches: " << folder << "/index.csv lists them" << std::endl;
  const std::vector<std::string> failed = convertMatches(arguments.match_forms, arguments.output_dir);
  for (const std::string& form : failed) {
    std::cerr << "the matches could not be written as " << form
              << ": see the message above; when its cause is "
              << "removed, run: rosrun corrsel export_matches.py --format " << form << " "
              << arguments.output_dir << std::endl;
  }
  return failed.empty();
}

/// @return exit code
int runDry(const Arguments& arguments) {
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  const auto open = [&arguments](const std::string& name) {
    return openDataset(name, arguments.config, false);
  };
  const auto convert = [&arguments](const std::string& run) {
    return convertMatches(arguments.match_forms, run);
  };
  switch (dryRun(arguments, open, convert, stop_requested)) {
    case DryRunOutcome::kInOrder:
      return kExitComplete;
    case DryRunOutcome::kProblems:
      return kExitIncomplete;
    case DryRunOutcome::kUnusable:
      return kExitUsage;
    case DryRunOutcome::kInterrupted:
      break;
  }
  return kExitInterrupted;
}

/// Names the node and, where there is a master, registers it.
/// @return keeps the node registered
std::optional<ros::NodeHandle> initRos(int argc, char** argv, const core::Shard& shard) {
  // The parts of a run may run at the same time, so each of them has its own node name.
  const std::string usual = shard.count == 1 ? "benchmark" : "benchmark_" + std::to_string(shard.index + 1);
  const NodeName name({argv + 1, argv + argc}, usual);
  // ROS removes its remappings from this copy; names like dataset:=vgg are arguments of this program.
  std::vector<char*> ros_argv = {argv[0]};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool replaced = name.chosen() && word.compare(0, 8, "__name:=") == 0;
    if (word.compare(0, 2, "__") == 0 && !replaced) ros_argv.push_back(argv[i]);
  }
  int ros_argc = static_cast<int>(ros_argv.size());
  ros::init(ros_argc, ros_argv.data(), name.chosen().value_or(usual), ros::init_options::NoSigintHandler);
  if (!name.note().empty()) std::cout << "note: " << name.note() << std::endl;
  std::optional<ros::NodeHandle> node;
  if (ros::master::check()) node.emplace("~");
  return node;
}

int run(int argc, char** argv) {
  enableSelectorPlugins();
  const Arguments arguments = parseArguments(argc, argv);
  if (arguments.help) {
    std::cout << helpText(benchmarkArguments());
    return kExitComplete;
  }
  if (arguments.list) {
    printList();
    return kExitComplete;
  }
  const core::BenchmarkConfig& config = arguments.config;
  const std::string& output_dir = arguments.output_dir;
  if (arguments.dry_run) return runDry(arguments);
  const Readers readers = openDatasets(config);

  const std::optional<ros::NodeHandle> node = initRos(argc, argv, arguments.shard);
  // All input is checked before the folder is made, so that a run that cannot start leaves no folder.
  std::vector<core::Remark> remarks;
  Sources sources = openBags(config.bags, arguments, &remarks);
  for (const std::string& other : arguments.merge) core::requireMergeable(other, config);
  core::RunFolder folder(output_dir, config, arguments.resume);
  std::cout << "results folder: " << output_dir << std::endl;
  for (const auto& [dataset, reason] : arguments.left_out) {
    std::cout << "without " << dataset << ": " << reason << std::endl;
  }
  for (const std::string& other : arguments.merge) {
    std::cout << core::mergeRun(folder, other, config) << " pairs taken over from " << other << std::endl;
  }
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  Reporter reporter(arguments.verbose, output_dir, node);
  for (const core::Remark& remark : remarks) {
    folder.appendRemark(remark);
    reporter.noticed(remark);
  }
  std::size_t broken = 0;
  std::vector<std::string> bags = config.bags;
  if (bags.empty()) {
    bags = datasetBags(config, readers, folder, reporter, &broken);
    sources = openBags(bags, arguments);
  }

  core::RunState state = runStages(arguments, bags, sources, folder, reporter);
  state.pairs_total += broken;
  state.pairs_failed += broken;
  reporter.finish(state);
  // Those of earlier sessions and merged runs are printed here; those of this session have been already.
  for (const core::TruthWarning& warning : folder.doubtfulTruths()) reporter.doubtful(warning);
  const core::Stopwatch watch;
  core::writeSummary(folder, state);
  folder.appendStage({"summary", watch.seconds()});
  std::cout << state.pairs_done << " of " << state.pairs_total << " pairs done, " << state.pairs_failed
            << " failed; peak memory " << state.peak_memory_mib << " MiB\n";
  if (state.interrupted)
    std::cout << "interrupted: continue with resume:=true output_dir:=" << output_dir << "\n";
  const bool reported = reportResults(arguments);
  const bool whole = arguments.shard.count == 1 && !state.interrupted;
  const bool exported = !whole || exportMatches(arguments);
  std::cout << "results: " << output_dir << std::endl;
  if (state.interrupted) return kExitInterrupted;
  return state.complete() && reported && exported ? kExitComplete : kExitIncomplete;
}

}  // namespace
}  // namespace corrsel

int main(int argc, char** argv) {
  try {
    return corrsel::run(argc, argv);
  } catch (const corrsel::core::RunFolderError& error) {
    std::cerr
        << "benchmark: " << error.what()
        << "\n(resume:=true continues the run that output_dir holds; output_dir:=FOLDER names another folder)"
        << std::endl;
  } catch (const std::exception& error) {
    std::cerr << "benchmark: " << error.what() << std::endl;
  }
  return corrsel::kExitUsage;
}
