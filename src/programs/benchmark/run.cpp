#include "programs/benchmark/run.h"

#include <sys/resource.h>

#include <atomic>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/stopwatch.h"
#include "corrsel/benchmark/runner.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/reference/reference_selectors.h"
#include "datasets/reader_source.h"
#include "datasets/sample.h"
#include "programs/benchmark/argument_table.h"
#include "programs/benchmark/arguments.h"
#include "programs/benchmark/dry_run.h"
#include "programs/started_programs.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

using Sources = std::vector<std::unique_ptr<core::PairSource>>;

constexpr int kExitComplete = 0, kExitIncomplete = 1, kExitUsage = 2, kExitInterrupted = 130;

std::atomic<bool> stop_requested{false};

void requestStop(int signal) {
  stop_requested = true;
  // A second Ctrl-C ends the process at once.
  std::signal(signal, SIG_DFL);
}

/// Folder of a dataset below data_root. Datasets that are made from the sample photographs use the folder of
/// the sample set, which is in the cache unless data_root has it. Those that need no folder have none.
std::string datasetFolder(const std::string& name, const std::string& data_root) {
  if (!core::needsFolder(name)) return "";
  if (core::needsSamplePhotographs(name)) {
    const fs::path below = fs::path(data_root) / "sample";
    return data_root.empty() || !fs::is_directory(below) ? core::sampleFolder() : below.string();
  }
  if (data_root.empty()) {
    throw UsageError("dataset '" + name + "' needs data_root: the folder that holds the folder '" +
                     core::imageDataset(name) + "'");
  }
  return (fs::path(data_root) / core::imageDataset(name)).string();
}

/// @param fetch  whether photographs that are missing are fetched; otherwise they are an error
void requireSamples(const std::string& folder, bool fetch, const BenchmarkFront& front) {
  for (const std::string& image : core::SampleReader::imageNames()) {
    if (fs::exists(fs::path(folder) / image)) continue;
    const std::string missing = "the sample photographs are missing in " + folder,
                      command = front.fetchCommand() + " " + folder;
    if (!fetch) throw core::DatasetError(missing + "; a run fetches them, and so does: " + command);
    std::cout << "fetching the sample photographs (Debian's opencv-doc, once, 96 MB)..." << std::endl;
    const fs::path script = front.fetchScript();
    if (script.empty() || runProgram(script, {folder}) != 0) {
      throw core::DatasetError(missing + " and could not be fetched; run: " + command);
    }
    return;
  }
}

std::unique_ptr<core::DatasetReader> openDataset(const std::string& name, const core::BenchmarkConfig& config,
                                                 bool fetch, const BenchmarkFront& front) {
  const std::string folder = datasetFolder(name, config.data_root);
  if (core::needsSamplePhotographs(name)) requireSamples(folder, fetch, front);
  return core::openDataset(name, folder, config.seed);
}

/// The datasets and bags of a run, which is read once for the results and once for the pictures.
class Inputs {
 public:
  Inputs(const core::BenchmarkConfig& config, const BenchmarkFront& front) : config_(config), front_(front) {
    for (const std::string& name : config.datasets) {
      readers_.push_back(openDataset(name, config, true, front));
      for (const std::string& remark : readers_.back()->remarks()) remarks_.push_back({name, "", "", remark});
    }
    for (const std::string& bag : config.bags) {
      const std::string name = core::bagName(bag);
      for (const std::string& note : front.openBag(bag, config).notes)
        remarks_.push_back({name, "", "", note});
    }
  }

  Sources open() const {
    Sources sources;
    for (const auto& reader : readers_) sources.push_back(std::make_unique<core::ReaderSource>(*reader));
    for (const std::string& bag : config_.bags) sources.push_back(front_.openBag(bag, config_).source);
    return sources;
  }

  /// What the readers decided and left out.
  const std::vector<core::Remark>& remarks() const { return remarks_; }

 private:
  const core::BenchmarkConfig& config_;
  const BenchmarkFront& front_;
  std::vector<std::unique_ptr<core::DatasetReader>> readers_;
  std::vector<core::Remark> remarks_;
};

/// Runs the grid, and then the stages that need its results. @return the state at the end
core::RunState runStages(const Arguments& arguments, const Inputs& inputs, core::RunFolder& folder,
                         Reporter& reporter) {
  const core::BenchmarkConfig& config = arguments.config;
  core::BenchmarkRunner runner(config, folder, reporter, stop_requested);
  core::RunState state = runner.run(inputs.open(), arguments.shard);
  reporter.endLine();
  // A part of a run does not have the results that example pairs are chosen from, and selectors are timed
  // only once.
  if (arguments.shard.count == 1 && !stop_requested) {
    runner.timeSelectors();
    reporter.endLine();
  }
  if (arguments.shard.count == 1 && !stop_requested) {
    runner.drawExamples(inputs.open());
    reporter.endLine();
  }
  state.interrupted = stop_requested;
  state.left_out_datasets = arguments.left_out;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  state.peak_memory_mib = static_cast<double>(usage.ru_maxrss / 1024);
  return state;
}

/// Starts the report at the end of the run: it prints the winners, and with `verbose` the tables of all
/// selectors, prints the guide where the experiment has one, writes the page, and converts the saved matches,
/// which are CSV files, to the other forms that are wanted.
/// @param whole  whether the run is no part and was not interrupted; else no matches are converted
/// @return whether everything could be made
bool reportResults(const Arguments& arguments, bool whole, const BenchmarkFront& front) {
  std::vector<std::string> words;
  if (arguments.verbose) words.emplace_back("--all");
  if (!arguments.report) words.emplace_back("--no-page");
  for (const std::string& form : arguments.match_forms) {
    if (whole && form != "csv") words.insert(words.end(), {"--export", form});
  }
  words.push_back(arguments.output_dir);
  std::cout << std::endl;
  if (runPython("corrsel.report", words) != 0) {
    std::cerr
        << "the run is saved, but its results could not be printed, reported or converted as a whole: see "
           "the message above. The means are in "
        << arguments.output_dir << "/summary.csv. When the cause is removed, run:\n  "
        << front.reportCommand();
    for (const std::string& word : words) std::cerr << " " << word;
    std::cerr << std::endl;
    return false;
  }
  if (!arguments.verbose) {
    std::cout << "All selectors and tolerances are in summary.csv; " << front.argument("verbose", "true")
              << " prints them, and so does\n  " << front.reportCommand() << " --all --no-page "
              << arguments.output_dir << "\n";
  }
  return true;
}

/// @return exit code
int runDry(const Arguments& arguments, const BenchmarkFront& front) {
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  const auto open = [&](const std::string& name) {
    return openDataset(name, arguments.config, false, front);
  };
  switch (dryRun(arguments, open, front, stop_requested)) {
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

/// Runs the grid into the folder of the run. @return exit code
int runGrid(const Arguments& arguments, BenchmarkFront& front) {
  const core::BenchmarkConfig& config = arguments.config;
  const std::string& output_dir = arguments.output_dir;
  // All input is checked before the folder is made, so that a run that cannot start leaves no folder.
  const Inputs inputs(config, front);
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
  const std::unique_ptr<Reporter> reporter = front.startReporter(arguments);
  for (const core::Remark& remark : inputs.remarks()) {
    folder.appendRemark(remark);
    reporter->noticed(remark);
  }

  const core::RunState state = runStages(arguments, inputs, folder, *reporter);
  reporter->finish(state);
  // Those of earlier sessions and merged runs are printed here; those of this session have been already.
  for (const core::TruthWarning& warning : folder.doubtfulTruths()) reporter->doubtful(warning);
  const core::Stopwatch watch;
  core::writeSummary(folder, state);
  folder.appendStage({"summary", watch.seconds()});
  std::cout << state.pairs_done << " of " << state.pairs_total << " pairs done, " << state.pairs_failed
            << " failed; peak memory " << state.peak_memory_mib << " MiB\n";
  if (state.interrupted)
    std::cout << "interrupted: continue with " << front.argument("resume", "true") << " "
              << front.argument("output_dir", output_dir) << "\n";
  const bool whole = arguments.shard.count == 1 && !state.interrupted;
  if (whole && !arguments.match_forms.empty()) {
    std::cout << "matches: " << output_dir << "/matches/index.csv lists them" << std::endl;
  }
  const bool reported = reportResults(arguments, whole, front);
  std::cout << "results: " << output_dir << std::endl;
  if (state.interrupted) return kExitInterrupted;
  return state.complete() && reported ? kExitComplete : kExitIncomplete;
}

}  // namespace

int runBenchmark(const std::vector<std::string>& words, BenchmarkFront& front) {
  core::addReferenceSelectors();
  try {
    const Arguments arguments = parseArguments(words, front);
    if (arguments.help) {
      CommandLineTable table = benchmarkArguments();
      table.program = front.program();
      std::cout << helpText(table);
      return kExitComplete;
    }
    if (arguments.list) {
      printList(front);
      return kExitComplete;
    }
    return arguments.dry_run ? runDry(arguments, front) : runGrid(arguments, front);
  } catch (const core::RunFolderError& error) {
    std::cerr << front.program() << ": " << error.what() << "\n(" << front.argument("resume", "true")
              << " continues the run that output_dir holds; " << front.argument("output_dir", "FOLDER")
              << " names another folder)" << std::endl;
  } catch (const std::exception& error) {
    std::cerr << front.program() << ": " << error.what() << std::endl;
  }
  return kExitUsage;
}

}  // namespace corrsel
