#include "binary_tests.h"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <iostream>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>

#include "datasets/sample.h"

namespace corrsel::core {
namespace {

constexpr int kOk = 0, kFailure = 1, kUsageError = 2;
constexpr double kCorrelationStep = 1.0 / 64;  // between two limits that are tried

std::int64_t countBits(const TestResults& a, const TestResults& b) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    count += static_cast<std::int64_t>(std::bitset<64>(a[i] & b[i]).count());
  }
  return count;
}

/// A test that is kept.
struct Kept {
  std::size_t test;
  double ones;
  TestResults results;
};

/// The first `wanted` tests, by falling variance, whose correlations are below the limit.
std::vector<std::size_t> testsBelow(double limit, const TestCandidates& candidates,
                                    const std::vector<std::size_t>& order,
                                    const std::vector<std::int64_t>& ones, std::size_t wanted) {
  const auto n = static_cast<double>(candidates.keypoints);
  std::vector<Kept> kept;
  std::vector<std::size_t>
      checks;  // numbers in `kept`: the test that rejected the last candidate comes first
  TestResults results;
  for (std::size_t i = 0; i < order.size() && kept.size() < wanted; ++i) {
    candidates.results(order[i], results);
    const auto a = static_cast<double>(ones[order[i]]);
    const auto similar = [&](std::size_t number) {
      const Kept& other = kept[number];
      const double variances = a * (n - a) * other.ones * (n - other.ones);
      if (!(variances > 0)) return true;
      const auto both = static_cast<double>(countBits(results, other.results));
      return !(std::abs(n * both - a * other.ones) / std::sqrt(variances) < limit);
    };
    const auto found = std::find_if(checks.begin(), checks.end(), similar);
    if (found != checks.end()) {
      std::rotate(checks.begin(), found, found + 1);
      continue;
    }
    checks.push_back(kept.size());
    kept.push_back({order[i], a, results});
  }
  std::vector<std::size_t> tests;
  for (const Kept& one : kept) tests.push_back(one.test);
  return tests;
}

}  // namespace

TestChoice chooseTests(const TestCandidates& candidates, std::size_t wanted) {
  std::vector<std::int64_t> ones(candidates.count);
  TestResults results;
  for (std::size_t i = 0; i < candidates.count; ++i) {
    candidates.results(i, results);
    ones[i] = countBits(results, results);
  }
  std::vector<std::size_t> order(candidates.count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(2 * ones[a] - candidates.keypoints) < std::abs(2 * ones[b] - candidates.keypoints);
  });
  for (double limit = kCorrelationStep; limit <= 1; limit += kCorrelationStep) {
    std::vector<std::size_t> tests = testsBelow(limit, candidates, order, ones, wanted);
    if (tests.size() == wanted) return {std::move(tests), limit};
  }
  throw std::runtime_error("fewer than " + std::to_string(wanted) +
                           " tests differ on these images; needed: the folder that fetch_samples.sh fills");
}

std::vector<cv::Mat> samplePhotographs(const std::string& folder) {
  std::vector<cv::Mat> images;
  for (const std::string& name : SampleReader::trainingImages()) {
    images.push_back(cv::imread(folder + "/" + name, cv::IMREAD_GRAYSCALE));
    if (images.back().empty()) {
      throw std::runtime_error(folder + "/" + name + " is missing or cannot be read; run fetch_samples.sh");
    }
  }
  return images;
}

int trainingProgram(int argc, char** argv, const std::string& name, const std::string& purpose,
                    const std::function<void(const std::string& folder)>& train) {
  if (argc != 2 || std::string(argv[1]).compare(0, 1, "-") == 0) {
    std::cerr << purpose << "\n\n"
              << name << " SAMPLE_FOLDER   writes the table as C++ source to standard output\n";
    return kUsageError;
  }
  try {
    train(argv[1]);
    return kOk;
  } catch (const std::exception& error) {
    std::cerr << name << ": " << error.what() << "\n";
    return kFailure;
  }
}

}  // namespace corrsel::core
