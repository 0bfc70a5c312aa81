#pragma once

#include <set>
#include <string>

#include "base/progress_meter.h"
#include "corrsel/benchmark/run_folder.h"
#include "corrsel/benchmark/runner.h"

namespace corrsel {

/// Prints the progress of the run.
class Reporter : public core::RunObserver {
 public:
  /// @param verbose  print every evaluated selection
  explicit Reporter(bool verbose);

  void progress(const core::Progress& progress) override;
  void evaluated(const core::ResultRow& row) override;
  void failed(const core::Failure& failure) override;
  void doubtful(const core::TruthWarning& warning) override;
  void noticed(const core::Remark& remark) override;

  /// The run has ended.
  virtual void finish(const core::RunState& state);

  /// Ends the progress bar's line.
  void endLine() { printer_.finish(); }

 private:
  core::ProgressPrinter printer_;
  bool verbose_;
  std::set<std::string> warnings_;  ///< that were printed
};

}  // namespace corrsel
