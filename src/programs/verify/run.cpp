#include "programs/verify/run.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <iostream>
#include <iterator>
#include <memory>
#include <optional>

#include "base/progress_meter.h"
#include "base/stopwatch.h"
#include "database/result_rows.h"
#include "programs/command_line.h"
#include "programs/verify/arguments.h"
#include "programs/verify/report.h"
#include "programs/verify/session.h"

namespace corrsel {
namespace {

using core::ImagePairKey;

constexpr int kExitComplete = 0, kExitFaulty = 1, kExitUsage = 2, kExitBusy = 3, kExitStorage = 4,
              kExitInterrupted = 130;
constexpr double kLineSeconds = 10;  // between lines of progress where there is no terminal

std::atomic<bool> stop_requested{false};

void requestStop(int signal) {
  stop_requested = true;
  std::signal(signal, SIG_DFL);  // A second Ctrl-C ends the process at once.
}

double processorSeconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

double peakMemoryMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// Progress of one stage on the terminal, or as lines in a log.
class Display {
 public:
  Display() : printer_(std::cerr, isatty(STDERR_FILENO) != 0, kLineSeconds) {}
  ~Display() { printer_.finish(); }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  void show(std::size_t done, std::size_t total, const std::string& what) {
    if (total == 0) return;
    if (!meter_) meter_.emplace(total, 0);
    printer_.show(meter_->at(done, what));
  }

 private:
  core::ProgressPrinter printer_;
  std::optional<core::ProgressMeter> meter_;
};

/// The stages of one call of the program.
class VerifyRun {
 public:
  explicit VerifyRun(const VerifyArguments& arguments)
      : arguments_(arguments), verifier_(arguments.verifier), configuration_(verifier_.configuration()) {}

  /// @return exit code
  int run() {
    session_ = openSession(arguments_);
    extract();
    match();
    if (stop_requested) return kExitInterrupted;
    merge();
    choosePairs();
    verify();
    if (!arguments_.run.dry_run) readStored();
    if (!arguments_.tracks.empty() && !report_.summary.interrupted) writeTracks();
    finish();
    std::cout << reportText(report_) << std::flush;
    writeReports(report_, arguments_.reports);
    if (report_.summary.interrupted) return kExitInterrupted;
    return faulty_images_ || !report_.faulty.empty() ? kExitFaulty : kExitComplete;
  }

 private:
  void printFaulty(const std::vector<std::string>& sentences) {
    for (const std::string& sentence : sentences) std::cerr << "faulty: " << sentence << std::endl;
    faulty_images_ = faulty_images_ || !sentences.empty();
  }

  void extract() {
    if (arguments_.images.empty()) return;
    core::ExtractionSummary summary;
    {
      Display display;
      summary = core::extractFeatures(
          {arguments_.images, arguments_.camera}, arguments_.extraction, arguments_.run.threads,
          *session_->database(),
          [&](std::size_t done, std::size_t total) { display.show(done, total, "images"); }, &stop_requested);
    }
    printFaulty(summary.refused);
    std::cout << arguments_.images.string() << ": " << summary.added << " images added with "
              << summary.features << " features, " << summary.skipped << " were there" << std::endl;
  }

  void match() {
    if (!arguments_.match || stop_requested) return;
    core::ColmapStore& database = *session_->database();
    const std::vector<core::StoredImage>& images = database.images();
    std::vector<ImagePairKey> pairs;
    if (!arguments_.pairs.empty()) {
      pairs = core::listedPairs(arguments_.pairs, images);
    } else if (arguments_.sequential > 0) {
      pairs = core::sequentialPairs(images, static_cast<std::size_t>(arguments_.sequential));
    } else {
      pairs = core::exhaustivePairs(images);
    }
    core::PairMatchingSummary summary;
    {
      Display display;
      summary = core::matchPairs(
          database, pairs, arguments_.matching, arguments_.run.threads,
          [&](std::size_t done, std::size_t total) { display.show(done, total, "matched"); },
          &stop_requested);
    }
    printFaulty(summary.faulty);
    std::cout << summary.matched << " pairs matched with " << summary.matches << " matches, "
              << summary.skipped << " had matches" << std::endl;
    reopen();
  }

  void merge() {
    if (arguments_.merge.empty()) return;
    if (arguments_.output.empty() && !arguments_.run.again && !session_->pairsOfOthers().empty()) {
      throw UsageError("--merge: another program has verified " +
                       std::to_string(session_->pairsOfOthers().size()) + " pairs of " +
                       arguments_.database.string() + "; give --output, or --again to replace them");
    }
    for (const std::filesystem::path& part : arguments_.merge) {
      const std::size_t pairs = core::mergeVerifications(session_->results(), part, configuration_);
      std::cout << part.string() << ": " << pairs << " verified pairs taken over" << std::endl;
    }
    reopen();
  }

  /// Forgets what the store has noted of the tables, which have changed since: which there are, and warnings.
  void reopen() {
    session_.reset();
    session_ = openSession(arguments_);
  }

  /// Fills chosen_ with the pairs of this run, and counts those that are left as others have verified them.
  void choosePairs() {
    const core::PairStore& store = session_->store();
    const std::vector<ImagePairKey> all =
        arguments_.pairs.empty() ? store.pairs() : core::listedPairs(arguments_.pairs, store.images());
    for (std::size_t number = 0; number < all.size(); ++number) {
      if (arguments_.shard.holds(number)) chosen_.push_back(all[number]);
    }
    if (arguments_.run.again) return;
    const std::vector<ImagePairKey> others = session_->pairsOfOthers();
    std::vector<ImagePairKey> left;
    std::set_difference(chosen_.begin(), chosen_.end(), others.begin(), others.end(),
                        std::back_inserter(left));
    report_.of_others = chosen_.size() - left.size();
    chosen_ = std::move(left);
  }

  void verify() {
    if (chosen_.empty()) return;
    core::VerificationOptions options = arguments_.run;
    options.pairs = chosen_;
    const double before = processorSeconds();
    Display display;
    report_.summary = core::verifyPairs(
        session_->store(), verifier_, options, [this](const core::VerifiedPair& pair) { note(pair); },
        [&](const core::VerificationProgress& progress) {
          display.show(progress.done, progress.total, std::to_string(progress.accepted) + " accepted");
        },
        &stop_requested);
    report_.processor_seconds = processorSeconds() - before;
  }

  void note(const core::VerifiedPair& pair) {
    if (pair.faulty) {
      report_.faulty.emplace_back(pair.pair, pair.message);
    } else if (arguments_.run.dry_run) {
      report_.pairs.push_back(reportPair(pair));
    }
  }

  /// Reads the results of this run and of earlier ones, so that a report does not depend on interruptions.
  void readStored() {
    const core::PairStore& store = session_->store();
    const std::vector<ImagePairKey> stored = store.verifiedPairs(configuration_);
    for (const ImagePairKey& pair : chosen_) {
      if (std::binary_search(stored.begin(), stored.end(), pair)) {
        const core::VerifiedPair verified = store.verified(pair);
        report_.pairs.push_back(reportPair(verified));
        if (arguments_.tracks.empty()) continue;
        if (const auto rotation = core::relativeRotation(verified)) rotations_.push_back(*rotation);
      }
    }
  }

  /// Joins the matches of accepted pairs to tracks, without the pairs that triplets of images accuse.
  void writeTracks() {
    report_.cycles = core::checkCycles(std::move(rotations_));
    std::vector<ImagePairKey> accused, accepted, pairs;
    for (const core::PairCycles& pair : report_.cycles->pairs) {
      if (pair.accused) accused.push_back(pair.pair);
    }
    for (const ReportPair& pair : report_.pairs) {
      if (pair.accepted()) accepted.push_back(pair.pair);
    }
    std::set_difference(accepted.begin(), accepted.end(), accused.begin(), accused.end(),
                        std::back_inserter(pairs));
    const core::Tracks tracks = core::buildTracks(session_->store(), pairs);
    core::writeTracks(arguments_.tracks, tracks, session_->store());
    report_.tracks = core::trackStatistics(tracks);
  }

  /// Completes the output, and the report with it.
  void finish() {
    report_.images = session_->store().images();
    const bool complete = !report_.summary.interrupted && !(arguments_.run.strict && !report_.faulty.empty());
    if (complete && !arguments_.run.dry_run) session_->complete(configuration_);
    report_.database = arguments_.database.string();
    report_.result = (session_->results().empty() ? arguments_.output : session_->results()).string();
    if (!arguments_.run.dry_run && !session_->results().empty()) {
      report_.checksum = core::checksumOfGeometries(session_->results());
    }
    report_.configuration = configuration_;
    report_.shard = arguments_.shard.text();
    report_.warnings = session_->warnings();
    report_.threads = arguments_.run.threads;
    report_.peak_memory_mib = peakMemoryMib();
    report_.dry_run = arguments_.run.dry_run;
  }

  const VerifyArguments& arguments_;
  core::PairVerifier verifier_;
  std::string configuration_;
  std::unique_ptr<Session> session_;
  std::vector<ImagePairKey> chosen_;
  std::vector<core::RelativeRotation> rotations_;  ///< of accepted pairs with a pose
  bool faulty_images_ = false;
  VerifyReport report_;
};

int exitCode(core::StoreError::Kind kind) {
  switch (kind) {
    case core::StoreError::Kind::kBusy:
      return kExitBusy;
    case core::StoreError::Kind::kStorage:
      return kExitStorage;
    case core::StoreError::Kind::kContent:
      break;
  }
  return kExitUsage;
}

}  // namespace

int runVerify(const std::vector<std::string>& words) {
  try {
    const VerifyArguments arguments = parseVerifyArguments(words);
    if (!arguments.help.empty()) {
      std::cout << arguments.help;
      return kExitComplete;
    }
    std::signal(SIGINT, requestStop);
    std::signal(SIGTERM, requestStop);
    return VerifyRun(arguments).run();
  } catch (const core::StoreError& error) {
    std::cerr << "corrsel_verify: " << error.what() << std::endl;
    return exitCode(error.kind());
  } catch (const std::invalid_argument& error) {
    std::cerr << "corrsel_verify: " << error.what() << std::endl;
    return kExitUsage;
  } catch (const std::exception& error) {  // the system's: no memory, no threads
    std::cerr << "corrsel_verify: " << error.what() << std::endl;
    return kExitStorage;
  }
}

}  // namespace corrsel
