#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iostream>
#include <numeric>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "datasets/sample.h"
#include "features/descriptors/freak_pattern.h"
#include "features/detectors/blob.h"

namespace {

using namespace corrsel::core;

constexpr const char* kUsage =
    "Chooses the 512 tests of FREAK on the sample images.\n"
    "\n"
    "train_freak SAMPLE_FOLDER   writes the table as C++ source to standard output\n";

constexpr int kOk = 0, kFailure = 1, kUsageError = 2;
constexpr double kPatternScale = 22;           // the paper's, px
constexpr double kPlaceStep = 1.0 / 8;         // keypoints are rounded to it, px
constexpr double kCorrelationStep = 1.0 / 64;  // between two limits that are tried

/// Results of all candidate tests, one column per test and one bit per keypoint.
struct Outcomes {
  std::vector<std::vector<std::uint64_t>> columns;
  std::int64_t keypoints = 0;
};

std::int64_t countBits(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    count += static_cast<std::int64_t>(std::bitset<64>(a[i] & b[i]).count());
  }
  return count;
}

/// Adds the keypoints of an image. Their positions and sizes are rounded, so that small differences between
/// processors and libraries do not change the table.
void addImage(const cv::Mat& grey, Outcomes& outcomes) {
  const std::vector<FreakPair> pairs = freakCandidatePairs();
  outcomes.columns.resize(pairs.size());
  Features features;
  // These are not the defaults, which may change without a new training.
  BlobOptions options;
  options.threshold = 4;
  options.min_sigma = 2;
  options.max_sigma = 40;
  options.layers = 3;
  options.edge_ratio = 10;
  BlobDetector(options).detect({grey}, features);
  const FreakSampler sampler(grey, kPatternScale);
  const auto rounded = [](float value) {
    return static_cast<float>(std::round(value / kPlaceStep) * kPlaceStep);
  };
  for (const cv::KeyPoint& keypoint : features.keypoints) {
    const cv::Point2f place(rounded(keypoint.pt.x), rounded(keypoint.pt.y));
    const double size = rounded(keypoint.size);
    if (!sampler.fits(place, size)) continue;
    const FreakSampler::Means means = sampler.means(place, size, sampler.orientation(place, size));
    const auto row = static_cast<std::size_t>(outcomes.keypoints++);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      std::vector<std::uint64_t>& column = outcomes.columns[i];
      if (row % 64 == 0) column.push_back(0);
      const std::uint64_t bit = means[pairs[i].first] > means[pairs[i].second] ? 1 : 0;
      column.back() |= bit << (row % 64);
    }
  }
}

/// The chosen tests, as indices in freakCandidatePairs(), and the largest correlation that was allowed.
struct Choice {
  std::vector<std::size_t> tests;
  double limit = 0;
};

/// The paper finds that the order of variance is coarse to fine. This does not hold for blobs, where tests of
/// all sizes have about the same variance.
void sortCoarseToFine(std::vector<std::size_t>& tests) {
  const auto fields = freakPattern();
  const std::vector<FreakPair> pairs = freakCandidatePairs();
  const auto extent = [&](std::size_t test) {
    return fields[pairs[test].first].sigma + fields[pairs[test].second].sigma;
  };
  // Fields of one ring may differ by rounding errors.
  constexpr double kEqual = 1e-9;
  std::stable_sort(tests.begin(), tests.end(), [&](std::size_t a, std::size_t b) {
    return std::round(extent(a) / kEqual) > std::round(extent(b) / kEqual);
  });
}

/// Section 4.2 of the paper: the tests are visited by falling variance. A test is kept if its correlation
/// with every test kept before is below a limit; the limit is the smallest that leaves enough tests.
Choice choose(const Outcomes& outcomes) {
  const std::size_t candidates = outcomes.columns.size();
  std::vector<std::int64_t> ones;
  for (const auto& column : outcomes.columns) ones.push_back(countBits(column, column));
  std::vector<std::size_t> order(candidates);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return std::abs(2 * ones[a] - outcomes.keypoints) < std::abs(2 * ones[b] - outcomes.keypoints);
  });

  // In the order of variance, the correlation of every test with the tests before it.
  std::vector<std::vector<double>> correlation(candidates);
  const auto n = static_cast<double>(outcomes.keypoints);
  for (std::size_t i = 0; i < candidates; ++i) {
    const auto a = static_cast<double>(ones[order[i]]);
    for (std::size_t j = 0; j < i; ++j) {
      const auto b = static_cast<double>(ones[order[j]]);
      const auto both =
          static_cast<double>(countBits(outcomes.columns[order[i]], outcomes.columns[order[j]]));
      const double variances = a * (n - a) * b * (n - b);
      correlation[i].push_back(variances > 0 ? std::abs(n * both - a * b) / std::sqrt(variances) : 1.0);
    }
  }
  for (double limit = kCorrelationStep; limit <= 1; limit += kCorrelationStep) {
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < candidates && kept.size() < kFreakTests; ++i) {
      const bool is_new =
          std::all_of(kept.begin(), kept.end(), [&](std::size_t j) { return correlation[i][j] < limit; });
      if (is_new) kept.push_back(i);
    }
    if (kept.size() < kFreakTests) continue;
    Choice choice;
    for (const std::size_t i : kept) choice.tests.push_back(order[i]);
    sortCoarseToFine(choice.tests);
    choice.limit = limit;
    return choice;
  }
  throw std::runtime_error(
      "fewer than 512 tests differ on these images; needed: the folder that fetch_samples.sh fills");
}

std::string source(const Choice& choice, const Outcomes& outcomes, std::size_t images) {
  std::ostringstream text;
  text << "// Generated by scripts/train_freak.sh; do not edit. " << outcomes.keypoints << " blobs on "
       << images << " sample images;\n// correlation of two tests below " << choice.limit << ".\n\n"
       << "#include \"features/descriptors/freak_pattern.h\"\n\nnamespace corrsel::core {\n\n// clang-format "
          "off\n"
       << "const std::array<FreakPair, kFreakTests> kFreakPairs = {{";
  const std::vector<FreakPair> pairs = freakCandidatePairs();
  for (std::size_t i = 0; i < choice.tests.size(); ++i) {
    const auto [a, b] = pairs[choice.tests[i]];
    text << (i % 10 ? " " : "\n  ") << "{" << int(a) << ", " << int(b) << "},";
  }
  text << "\n}};\n// clang-format on\n\n}  // namespace corrsel::core\n";
  return text.str();
}

bool isImage(const std::string& name) {
  // The other files of the sample set are a homography and a disparity map.
  return name.find(".xml") == std::string::npos && name.find("GT") == std::string::npos;
}

int run(const std::string& folder) {
  Outcomes outcomes;
  std::size_t images = 0;
  for (const std::string& name : SampleReader::imageNames()) {
    if (!isImage(name)) continue;
    const cv::Mat grey = cv::imread(folder + "/" + name, cv::IMREAD_GRAYSCALE);
    if (grey.empty()) {
      throw std::runtime_error(folder + "/" + name + " is missing or cannot be read; run fetch_samples.sh");
    }
    addImage(grey, outcomes);
    ++images;
  }
  const Choice choice = choose(outcomes);
  std::cout << source(choice, outcomes, images);
  std::cerr << outcomes.keypoints << " keypoints, correlation below " << choice.limit << "\n";
  return kOk;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2 || std::string(argv[1]).compare(0, 1, "-") == 0) {
    std::cerr << kUsage;
    return kUsageError;
  }
  try {
    return run(argv[1]);
  } catch (const std::exception& error) {
    std::cerr << "train_freak: " << error.what() << "\n";
    return kFailure;
  }
}
