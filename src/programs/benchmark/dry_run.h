#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "corrsel/datasets/reader.h"
#include "programs/benchmark/front.h"

namespace corrsel {

/// How a dry run ended.
enum class DryRunOutcome { kInOrder, kProblems, kUnusable, kInterrupted };

/// Opens a dataset of the configuration. May throw core::DatasetError or std::invalid_argument.
using OpenDataset = std::function<std::unique_ptr<core::DatasetReader>(const std::string& name)>;

/// Prints the configuration, every problem of the data, how many selections the run makes, and how long it
/// takes and how much it writes, its matches as csv included. For that, the files of all pairs are checked,
/// at most 500 pairs of each dataset or bag are decoded and inspected (PairInspector), and at most five of
/// them are run, in a temporary folder that is removed.
/// @param stop  may be set by a signal handler; the dry run ends soon after
DryRunOutcome dryRun(const Arguments& arguments, const OpenDataset& open, const BenchmarkFront& front,
                     const std::atomic<bool>& stop);

}  // namespace corrsel
