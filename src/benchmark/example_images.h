#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "benchmark/tables.h"

namespace corrsel::core {

/// The pictures that images/index.csv lists. Damaged lines are left out.
std::vector<ExampleImage> readExampleImages(const std::string& folder);

/// Removes all pictures that are listed, and empties the list.
void clearExampleImages(const std::string& folder);

/// Writes a picture (8-bit BGR, as JPEG) and lists it. `image.file` is filled in. Throws RunFolderError where
/// it cannot be written.
void appendExampleImage(const std::string& folder, ExampleImage image, const cv::Mat& picture);

}  // namespace corrsel::core
