#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/datasets/pair_source.h"
#include "programs/benchmark/arguments.h"
#include "programs/benchmark/reporter.h"

namespace corrsel {

/// A bag that was opened.
struct OpenedBag {
  std::unique_ptr<core::PairSource> source;
  std::vector<std::string> notes;  ///< what was left out and decided, one sentence without its full stop each
};

/// What the program has beside folders and the terminal. The base class is `corrsel_benchmark`, which has
/// nothing beside them; the program of the ROS package adds bags, topics and selectors of other packages.
class BenchmarkFront {
 public:
  virtual ~BenchmarkFront() = default;

  virtual std::string program() const { return "corrsel_benchmark"; }

  /// The folder in which runs without output_dir get folders of their own: $XDG_DATA_HOME/corrsel, or
  /// ~/.local/share/corrsel.
  virtual std::filesystem::path runsFolder() const;

  /// What a user types to set an argument, e.g. "--resume" for {"resume", "true"}.
  virtual std::string argument(const std::string& name, const std::string& value) const;

  /// What a user types to start fetch_samples.sh, or where it lies.
  virtual std::string fetchCommand() const;

  /// What a user types to make the report of a run.
  virtual std::string reportCommand() const;

  /// fetch_samples.sh; empty where it is not found.
  virtual std::filesystem::path fetchScript() const;

  /// Names of selectors of other packages, and why some of them are missing.
  virtual std::vector<std::string> selectorPlugins() const { return {}; }
  virtual std::vector<std::string> selectorPluginProblems() const { return {}; }

  /// Throws UsageError without ROS, else what the reading of bags throws.
  virtual OpenedBag openBag(const std::string& path, const core::BenchmarkConfig& config) const;

  /// What prints, and where there is a ROS master publishes, the progress of the run that begins now.
  virtual std::unique_ptr<Reporter> startReporter(const Arguments& arguments);
};

}  // namespace corrsel
