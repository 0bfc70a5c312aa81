#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace corrsel::core {

/// The results of a test: keypoint i in bit i % 64 of word i / 64, with zeros behind the last keypoint.
using TestResults = std::vector<std::uint64_t>;

/// Candidates for the tests of a binary descriptor, and their results on training keypoints.
struct TestCandidates {
  std::size_t count;
  std::int64_t keypoints;
  std::function<void(std::size_t test, TestResults& results)> results;  ///< sets the results of a test
};

/// The chosen tests, in the order in which they were chosen, and the limit of their correlation.
struct TestChoice {
  std::vector<std::size_t> tests;
  double limit = 0;
};

/// Chooses tests whose results are evenly distributed and little correlated: the candidates are visited by
/// falling variance. A candidate is kept if its correlation with every test kept before is below a limit; the
/// limit is the smallest multiple of 1/64 that leaves enough tests. Throws std::runtime_error if there are
/// too few different candidates.
///
/// Source: Rublee, Rabaud, Konolige and Bradski, "ORB: an efficient alternative to SIFT or SURF", ICCV 2011,
/// section 4.3; also used by Alahi, Ortiz and Vandergheynst, "FREAK: Fast Retina Keypoint", CVPR 2012.
TestChoice chooseTests(const TestCandidates& candidates, std::size_t wanted);

/// SampleReader::trainingImages() as grey images. Throws std::runtime_error for a missing file.
std::vector<cv::Mat> samplePhotographs(const std::string& folder);

/// The main() of a program with the arguments SAMPLE_FOLDER, or with its usage if they are anything else.
/// @param train  writes the table to standard output and a summary to standard error
/// @return exit code: 0, 1 for an exception, or 2 for wrong arguments
int trainingProgram(int argc, char** argv, const std::string& name, const std::string& purpose,
                    const std::function<void(const std::string& folder)>& train);

}  // namespace corrsel::core
