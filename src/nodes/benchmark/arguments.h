#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/benchmark/config.h"
#include "corrsel/benchmark/run_folder.h"
#include "ros/bags/dataset_bag.h"

namespace corrsel {

/// The command line makes no sense; the text names the argument, its value and what is valid.
class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// What the command line of the benchmark asks for.
struct Arguments {
  core::BenchmarkConfig config;  ///< resolved
  BagTopics bag_topics;
  core::Shard shard;
  std::vector<std::string> merge;  ///< absolute folders
  std::string output_dir;          ///< absolute
  bool resume = false, report = true, verbose = false;
  bool help = false, list = false, dry_run = false;
  std::vector<std::pair<std::string, std::string>> left_out;  ///< datasets of the preset that are not there
};

/// Reads --NAME VALUE, --NAME=VALUE and NAME:=VALUE; ROS's own remappings (__name:=...) are left out. With
/// help or list nothing else is checked. Throws UsageError and std::invalid_argument.
Arguments parseArguments(int argc, char** argv);

void printHelp();

/// Datasets, features, selectors with presets, those of other packages, and all their options.
void printList();

}  // namespace corrsel
