#pragma once

#include <string>

namespace corrsel::testing {

/// Folder of the package's sources.
std::string sourceDir();

/// Root of catkin's devel space; empty in a build without ROS.
std::string develDir();

/// Folder of the real datasets, whether it exists or not. The environment variable CORRSEL_TEST_DATA takes
/// precedence over the folder that was given to CMake.
std::string realDataDir();

}  // namespace corrsel::testing
