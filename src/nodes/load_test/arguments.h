#pragma once

#include <limits>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

namespace corrsel::load_test {

/// What the command line says.
struct Arguments {
  std::string images;  ///< "LEFT,RIGHT", a folder, or empty for the sample photographs
  cv::Size size;       ///< px; empty = as the files are
  std::string encoding = "mono8";
  double rate = 10.0;  ///< pairs per second
  double seconds = 10.0;
  double reconfigure = 0.0;  ///< s between two changes of parameters; 0 = none
  std::vector<std::string> selectors = {"gms", "lpm", "nnsr", "ransac"};  ///< that changes choose from
  std::string matcher_node = "feature_matcher", selector_node = "selector";
  int seed = 0;
  std::string csv;         ///< file; empty = none
  double interval = 60.0;  ///< s per line of the table
  double wait = 30.0;      ///< s, for the first answer
  double max_drop_ratio = 1.0;
  double max_memory_growth = std::numeric_limits<double>::infinity();
  bool help = false;
};

/// @param words  without the program's name and ROS's own arguments
/// Throws std::invalid_argument naming the argument and what it takes.
Arguments parseArguments(const std::vector<std::string>& words);

std::string usage();

}  // namespace corrsel::load_test
