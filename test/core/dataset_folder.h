#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "datasets/sample.h"

namespace corrsel::core::testing {

/// The folder of the sample photographs: that of the environment, for a machine without the cache, or the
/// usual one.
inline std::string samplePhotographs() {
  const char* const set = std::getenv("CORRSEL_SAMPLE_DIR");
  return set != nullptr ? set : sampleFolder();
}

/// A separate folder for each test, removed at the end.
class DatasetFolder : public ::testing::Test {
 protected:
  void SetUp() override {
    root_ = std::filesystem::temp_directory_path() / ("corrsel_datasets_" + std::to_string(::getpid()));
    std::filesystem::remove_all(root_);
    std::filesystem::create_directories(root_);
  }

  void TearDown() override { std::filesystem::remove_all(root_); }

  /// Writes a file and the folders above it. `path` is relative to the test's folder.
  void write(const std::filesystem::path& path, const std::string& text) const {
    std::filesystem::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }

  /// Writes a small image of one value: grey if the format requires it, otherwise colour.
  void writeImage(const std::filesystem::path& path, int value = 0) const {
    std::filesystem::create_directories((root_ / path).parent_path());
    const int type = path.extension() == ".pgm" ? CV_8UC1 : CV_8UC3;
    ASSERT_TRUE(cv::imwrite((root_ / path).string(), cv::Mat(12, 20, type, cv::Scalar::all(value)))) << path;
  }

  std::string path(const std::filesystem::path& relative = "") const {
    return (relative.empty() ? root_ : root_ / relative).string();
  }

  std::filesystem::path root_;
};

}  // namespace corrsel::core::testing
