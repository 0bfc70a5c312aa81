#pragma once

#include <limits>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "programs/command_line.h"

namespace corrsel::load_test {

/// The arguments of load_test and their defaults.
const CommandLineTable& argumentTable();

/// The values of the command line.
struct Arguments {
  std::string images;                  ///< "LEFT,RIGHT", a folder, or empty for the sample photographs
  cv::Size size;                       ///< px; empty = as the files are
  std::string encoding;                ///< mono8 or bgr8
  bool sequence = false;               ///< one camera
  bool calibrated = false;             ///< with camera_info
  int mask_period = 0;                 ///< images from one mask to the next; 0 = none
  double rate = 0.0;                   ///< pairs per second; of a sequence, images
  double seconds = 0.0;                ///< length of the test
  double reconfigure = 0.0;            ///< s between two changes of parameters; 0 = none
  std::vector<std::string> selectors;  ///< selectors that changes choose from
  std::string matcher_node, selector_node;
  int seed = 0;
  std::string csv;        ///< file; empty = none
  double interval = 0.0;  ///< s per line of the table
  double wait = 0.0;      ///< s, for the first result
  double max_drop_ratio = 1.0;
  double max_memory_growth = std::numeric_limits<double>::infinity();
};

/// Throws UsageError naming the argument, its value and what is valid.
Arguments argumentsOf(const ArgumentValues& values);

}  // namespace corrsel::load_test
