#pragma once

#include <string>
#include <utility>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/shard.h"
#include "programs/command_line.h"

namespace corrsel {

class BenchmarkFront;

/// What the command line of the benchmark asks for.
struct Arguments {
  core::BenchmarkConfig config;  ///< resolved
  core::Shard shard;
  std::vector<std::string> merge;        ///< absolute folders
  std::string output_dir;                ///< absolute
  std::vector<std::string> match_forms;  ///< in which forms the matches are saved: csv, npz, colmap
  bool resume = false, report = true, verbose = false;
  bool help = false, list = false, dry_run = false;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< datasets of the preset that are not there
};

/// Reads the command line, see benchmarkArguments(). With help or list nothing else is checked. Throws
/// UsageError, or std::invalid_argument where the configuration is not valid.
/// @param words  without the program's name
Arguments parseArguments(const std::vector<std::string>& words, const BenchmarkFront& front);

/// Prints datasets, features and selectors with their presets and options, also those of other packages.
void printList(const BenchmarkFront& front);

}  // namespace corrsel
