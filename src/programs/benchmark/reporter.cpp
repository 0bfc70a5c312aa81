#include "programs/benchmark/reporter.h"

#include <unistd.h>

#include <iostream>

namespace corrsel {

Reporter::Reporter(bool verbose) : printer_(std::cout, isatty(STDOUT_FILENO) != 0), verbose_(verbose) {}

void Reporter::progress(const core::Progress& progress) { printer_.show(progress); }

void Reporter::evaluated(const core::ResultRow& row) {
  if (!verbose_) return;
  printer_.finish();
  std::cout << row.id.text() << " " << row.features << " " << row.preselection << " " << row.selector << ": "
            << row.n_selected << " of " << row.n_putative << " selected, " << toString(row.status)
            << std::endl;
}

void Reporter::failed(const core::Failure& failure) {
  printer_.finish();
  std::cerr << "failed (" << failure.stage
            << "): " << (failure.id.dataset.empty() ? "" : failure.id.text() + ": ") << failure.error
            << std::endl;
}

void Reporter::doubtful(const core::TruthWarning& warning) {
  const std::string text = warning.text();
  if (!warnings_.insert(text).second) return;
  printer_.finish();
  std::cerr << "warning: doubtful ground truth: " << text << std::endl;
}

void Reporter::noticed(const core::Remark& remark) {
  printer_.finish();
  std::cout << "note: " << remark.sentence() << std::endl;
}

void Reporter::finish(const core::RunState&) { printer_.finish(); }

}  // namespace corrsel
