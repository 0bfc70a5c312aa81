#include "programs/benchmark/dry_run.h"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <set>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/progress_meter.h"
#include "base/stopwatch.h"
#include "base/temporary_folder.h"
#include "base/text.h"
#include "benchmark/dataset_check.h"
#include "benchmark/estimate.h"
#include "benchmark/tables.h"
#include "corrsel/benchmark/experiments.h"
#include "corrsel/benchmark/runner.h"
#include "datasets/dataset_report.h"
#include "datasets/reader_source.h"

namespace corrsel {
namespace {

namespace fs = std::filesystem;

// Decoding and inspecting a pair takes about 0.1 s, so these take about a minute.
constexpr std::size_t kInspectedPairs = 500;
constexpr std::size_t kTriedPairs = 5;
// After which no further pair of a dataset is tried.
constexpr double kTrialSeconds = 10;

/// The user has asked the dry run to stop.
struct Interrupted {};

/// Some pairs of a dataset.
class DatasetSubset : public core::DatasetReader {
 public:
  DatasetSubset(const core::DatasetReader& whole, std::vector<std::size_t> indices)
      : whole_(whole), indices_(std::move(indices)) {}
  std::size_t size() const override { return indices_.size(); }
  core::PairId id(std::size_t index) const override { return whole_.id(indices_.at(index)); }
  core::ImagePair read(std::size_t index) const override { return whole_.read(indices_.at(index)); }
  std::vector<std::string> files() const override { return whole_.files(); }

 private:
  const core::DatasetReader& whole_;
  std::vector<std::size_t> indices_;
};

double bytesIn(const fs::path& folder) {
  std::uintmax_t bytes = 0;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) bytes += entry.file_size();
  }
  return static_cast<double>(bytes);
}

/// Counts what a run makes, and ends it when it has taken long enough.
class TrialObserver : public core::RunObserver {
 public:
  explicit TrialObserver(const std::atomic<bool>& interrupted) : interrupted_(interrupted) {}

  void progress(const core::Progress& progress) override {
    if (progress.done > 0 && watch_.seconds() > kTrialSeconds) stop = true;
  }
  void evaluated(const core::ResultRow&) override {
    ++selections;
    if (interrupted_) stop = true;
  }
  void failed(const core::Failure& failure) override { failures.push_back(failure); }
  void noticed(const core::Remark& remark) override { remarks.push_back(remark); }

  std::atomic<bool> stop{false};
  std::size_t selections = 0;
  std::vector<core::Failure> failures;
  std::vector<core::Remark> remarks;

 private:
  const std::atomic<bool>& interrupted_;
  core::Stopwatch watch_;
};

/// Opens what a trial reads.
using OpenSource = std::function<std::unique_ptr<core::PairSource>()>;

class DryRun {
 public:
  DryRun(const Arguments& arguments, const BenchmarkFront& front, const std::atomic<bool>& stop)
      : arguments_(arguments), front_(front), stop_(stop), printer_(std::cout, isatty(STDOUT_FILENO) != 0) {}

  void addDataset(const std::string& name, const core::DatasetReader& reader);
  void addBag(const std::string& bag);
  void unusable(const std::string& error) {
    print("unusable: " + error);
    unusable_ = true;
  }
  void printEstimate();
  DryRunOutcome outcome() const {
    return unusable_       ? DryRunOutcome::kUnusable
           : problems_ > 0 ? DryRunOutcome::kProblems
                           : DryRunOutcome::kInOrder;
  }

 private:
  void print(const std::string& line) {
    printer_.finish();
    std::cout << line << std::endl;
  }
  void problem(const std::string& line) {
    print(line);
    ++problems_;
  }
  void note(const std::string& sentence) {
    if (notes_.insert(sentence).second) print("note: " + sentence);
  }
  void goOn(const core::Progress& progress) {
    if (stop_) throw Interrupted();
    printer_.show(progress);
  }
  void printSample(std::size_t inspected, std::size_t pairs, const std::string& which) {
    if (inspected < pairs) {
      note(std::to_string(inspected) + " of the " + std::to_string(pairs) + " pairs, " + which +
           ", were decoded and inspected");
    }
  }
  void printFindings(const core::PairInspector& inspector) {
    for (const std::string& finding : inspector.findings()) problem(finding);
  }
  core::Trial newTrial(const std::string& name, std::size_t readable_pairs);
  void tryRun(const OpenSource& open, core::Trial& trial);
  void requireSpace(const std::string& folder, double bytes);

  const Arguments& arguments_;
  const BenchmarkFront& front_;
  const std::atomic<bool>& stop_;
  core::ProgressPrinter printer_;
  core::TemporaryFolder folder_{"corrsel_dry_run"};
  std::vector<core::Trial> trials_;
  std::set<std::string> notes_;
  std::size_t number_ = 0;  ///< of the next pair in the undivided run
  std::size_t problems_ = 0;
  bool unusable_ = false;
};

/// A trial with the number of pairs that the run takes, and nothing tried yet.
core::Trial DryRun::newTrial(const std::string& name, std::size_t readable_pairs) {
  const auto max_pairs = static_cast<std::size_t>(arguments_.config.max_pairs);
  core::Trial trial;
  trial.name = name;
  for (std::size_t i = 0; i < (max_pairs > 0 ? std::min(readable_pairs, max_pairs) : readable_pairs); ++i) {
    trial.pairs += arguments_.shard.holds(number_++);
  }
  return trial;
}

void DryRun::addDataset(const std::string& name, const core::DatasetReader& reader) {
  core::PairInspector inspector(arguments_.config.threads);
  const core::ProgressMeter meter(reader.size(), 0);
  const std::vector<std::size_t> inspected = core::evenlySpaced(reader.size(), kInspectedPairs);
  const core::DatasetReport report = core::describe(
      reader, inspected,
      {[&inspector](const core::ImagePair& pair) { inspector.add(pair); },
       [&](std::size_t done, const core::PairId& id) { goOn(meter.at(done, "checking " + id.text())); }});
  printer_.finish();
  std::cout << report.text() << std::flush;
  for (const std::string& remark : reader.remarks()) note(remark);
  problems_ += report.problems.size();
  printSample(inspected.size(), reader.size(), "evenly spaced");
  printFindings(inspector);

  std::vector<std::size_t> readable;
  for (std::size_t i = 0; i < reader.size(); ++i) {
    if (!std::binary_search(report.broken.begin(), report.broken.end(), i)) readable.push_back(i);
  }
  core::Trial trial = newTrial(name, readable.size());
  if (arguments_.config.max_pairs > 0) {
    readable.resize(std::min(readable.size(), static_cast<std::size_t>(arguments_.config.max_pairs)));
  }
  std::vector<std::size_t> tried;
  for (const std::size_t k : core::evenlySpaced(readable.size(), kTriedPairs)) tried.push_back(readable[k]);
  const DatasetSubset subset(reader, tried);
  if (subset.size() > 0) {
    tryRun([&subset] { return std::make_unique<core::ReaderSource>(subset); }, trial);
  }
  trials_.push_back(trial);
}

void DryRun::addBag(const std::string& bag) {
  const OpenedBag opened = front_.openBag(bag, arguments_.config);
  core::PairSource* const source = opened.source.get();
  const std::string name = core::bagName(bag);
  const std::size_t inspected = std::min(source->size(), kInspectedPairs);
  const core::ProgressMeter meter(inspected, 0);
  core::PairInspector inspector(arguments_.config.threads);
  std::vector<std::string> broken;
  for (std::size_t i = 0; i < inspected; ++i) {
    try {
      core::ImagePair pair;
      if (!source->next(pair)) break;
      inspector.add(pair);
    } catch (const core::DatasetError& error) {
      broken.emplace_back(error.what());
    }
    goOn(meter.at(i + 1, "checking " + bag));
  }
  print(name + ": found " + std::to_string(source->size()) + " pairs, " +
        (broken.empty() ? "none" : std::to_string(broken.size())) + " of them broken");
  for (const std::string& line : broken) problem("broken: " + line);
  printSample(inspected, source->size(), "the first ones");
  for (const std::string& sentence : opened.notes) note(sentence);
  printFindings(inspector);
  core::Trial trial = newTrial(name, source->size());
  if (broken.size() < inspected) {
    tryRun([this, &bag] { return front_.openBag(bag, arguments_.config).source; }, trial);
  }
  trials_.push_back(trial);
}

/// Runs the first pairs of a source.
void DryRun::tryRun(const OpenSource& open, core::Trial& trial) {
  core::BenchmarkConfig config = arguments_.config;
  config.max_pairs = kTriedPairs;
  const std::string path = (folder_.path() / std::to_string(trials_.size())).string();
  core::RunFolder folder(path, config, false);
  const double empty = bytesIn(path);
  TrialObserver observer(stop_);
  core::BenchmarkRunner runner(config, folder, observer, observer.stop);
  const auto sources = [&] {
    std::vector<std::unique_ptr<core::PairSource>> opened;
    opened.push_back(open());
    return opened;
  };
  print("trying pairs of " + trial.name + " ...");
  runner.run(sources());
  if (stop_) throw Interrupted();
  trial.selections = observer.selections;
  trial.run.count = folder.doneCount();
  trial.run.bytes = bytesIn(path) - empty;
  const std::string stages = fs::path(path) / core::stagesTable().file();
  for (const core::StageRow& row : core::stagesTable().intactRows(core::readTextFile(stages))) {
    trial.run.seconds += row.stage.seconds;
  }
  for (const core::Failure& failure : observer.failures) {
    problem("failed (" + failure.stage + "): " + failure.id.text() + ": " + failure.error);
  }
  for (const core::Remark& remark : observer.remarks) note(remark.sentence());
  if (arguments_.shard.count > 1 || trial.run.count == 0) return;
  observer.stop = false;
  const core::Stopwatch watch;
  runner.drawExamples(sources());
  if (stop_) throw Interrupted();
  trial.pictures.seconds = watch.seconds();
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(path) / "images")) {
    if (entry.path().extension() == ".csv") continue;
    ++trial.pictures.count;
    trial.pictures.bytes += static_cast<double>(entry.file_size());
  }
}

/// Notes a problem where a folder that may not exist yet has less free space than is needed.
void DryRun::requireSpace(const std::string& folder, double bytes) {
  fs::path existing = folder;
  while (!fs::exists(existing) && existing.has_relative_path()) existing = existing.parent_path();
  std::error_code error;
  const fs::space_info space = fs::space(existing, error);
  if (error || static_cast<double>(space.available) >= bytes) return;
  const auto mib = [](double count) { return std::to_string(std::llround(count / (1 << 20))) + " MiB"; };
  problem("no space: " + existing.string() + " has " + mib(static_cast<double>(space.available)) +
          " free, and the run writes about " + mib(bytes) +
          " there; free some space, or give another folder");
}

void DryRun::printEstimate() {
  if (trials_.empty()) return;
  const core::BenchmarkConfig& config = arguments_.config;
  const auto counted = [](std::size_t count, const std::string& noun) {
    return std::to_string(count) + " " + noun + (count == 1 ? "" : "s");
  };
  std::cout << "\npairs x " << counted(config.grid().size(), "cell") << " (features and preselection) x "
            << counted(config.selectors.size(), "selector") << " x "
            << counted(static_cast<std::size_t>(config.repetitions), "repetition")
            << " = selections; each is a row of pairs.csv. Matches that a dataset provides have cells of "
               "their own, and nnsr does not run after "
               "itself.\n\n";
  const bool draws = arguments_.shard.count == 1 && !core::makesVariants(config.experiment);
  const std::size_t pictures = draws ? core::maxPictures(trials_, config.selectors.size() - 1) : 0;
  std::cout << core::estimateTable(trials_, pictures) << "\nThe numbers are in proportion to ";
  std::vector<std::string> tried;
  for (const core::Trial& trial : trials_) {
    tried.push_back(counted(trial.run.count, "pair") + " of " + trial.name);
  }
  std::cout
      << core::joinList(tried, ", ") << ", which were run with " << counted(config.threads, "thread")
      << " on this machine. They do not contain the summary, the report and matches in other forms than csv"
      << (config.measuresScaling() ? ", nor the speed test of this experiment" : "") << ".\n";
  const core::Estimate sum = core::sumOf(trials_, pictures);
  requireSpace(arguments_.output_dir, sum.run_bytes);
  std::cout << (problems_ == 0 ? "no problems were found" : counted(problems_, "problem") + ", see above")
            << std::endl;
}

}  // namespace

DryRunOutcome dryRun(const Arguments& arguments, const OpenDataset& open, const BenchmarkFront& front,
                     const std::atomic<bool>& stop) {
  std::cout << arguments.config.toYaml() << "output_dir: " << arguments.output_dir << "\n\n";
  for (const auto& [dataset, reason] : arguments.left_out) {
    std::cout << "without " << dataset << ": " << reason << "\n";
  }
  DryRun dry_run(arguments, front, stop);
  const auto guarded = [&dry_run](const auto& work) {
    try {
      work();
    } catch (const core::DatasetError& error) {
      dry_run.unusable(error.what());
    } catch (const std::invalid_argument& error) {
      dry_run.unusable(error.what());
    }
  };
  try {
    for (const std::string& name : arguments.config.datasets) {
      guarded([&] { dry_run.addDataset(name, *open(name)); });
    }
    for (const std::string& bag : arguments.config.bags) guarded([&] { dry_run.addBag(bag); });
    dry_run.printEstimate();
  } catch (const Interrupted&) {
    return DryRunOutcome::kInterrupted;
  }
  return dry_run.outcome();
}

}  // namespace corrsel
