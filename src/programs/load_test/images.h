#pragma once

#include <sensor_msgs/Image.h>

#include <vector>

#include "arguments.h"

namespace corrsel::load_test {

/// A stereo pair ready to be stamped and sent.
struct StereoImages {
  sensor_msgs::Image left, right;
};

/// The pairs that the arguments ask for, all in memory. Throws core::DatasetError naming the file that is
/// missing or cannot be read, and the remedy.
std::vector<StereoImages> loadImages(const Arguments& arguments);

}  // namespace corrsel::load_test
