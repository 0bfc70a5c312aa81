// Compares the homographies of selectors with those of cv::findHomography on the same putative matches, by
// the error of the corners; see docs/evaluation.md.
#include <algorithm>
#include <cstdio>
#include <functional>
#include <iostream>
#include <limits>
#include <map>
#include <opencv2/calib3d.hpp>
#include <optional>

#include "base/stopwatch.h"
#include "base/text.h"
#include "corrsel/benchmark/config.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/pose.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/reference/reference_selectors.h"
#include "corrsel/selectors/factory.h"
#include "opencv_version.h"
#include "programs/command_line.h"

namespace {

using namespace corrsel::core;

constexpr double kThreshold = 3;         // px, of cv::findHomography
constexpr double kConfidence = 0.99999;  // of cv::findHomography
constexpr int kIterations = 10000;       // of cv::findHomography, at most

const corrsel::CommandLineTable& argumentTable() {
  static const corrsel::CommandLineTable table = {
      "homography_quality",
      "Compares the homographies of selectors with those of cv::findHomography (3 px) on the same putative "
      "matches of the pairs of a dataset, and prints tables in Markdown.",
      {},
      {
          {"data_root", "FOLDER", "", "folder that holds the folder of the dataset"},
          {"dataset", "NAME", "vgg", "dataset with homographies"},
          {"features", "LIST", "sift+sift,orb+orb", "features, comma-separated"},
          {"selectors", "LIST", "usac:h,ransac:h,auto",
           "selectors that estimate a homography, comma-separated"},
          {"options", "LIST", "", "options of the algorithms: sift.max_features=2000,..."},
          {"threads", "N", "1", "threads that extract and match"},
      },
      "exit code: 0 = measured, 2 = wrong arguments\n"};
  return table;
}

using Homography = std::optional<cv::Matx33d>;

struct Estimator {
  std::string name;
  std::function<Homography(const Correspondences&)> estimate;
  std::vector<double> errors, seconds;
};

Homography findHomography(const Correspondences& matches, int method) {
  std::vector<cv::Point2f> left, right;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    left.emplace_back(matches.left_x[i], matches.left_y[i]);
    right.emplace_back(matches.right_x[i], matches.right_y[i]);
  }
  if (left.size() < 4) return {};
  const cv::Mat found =
      cv::findHomography(left, right, method, kThreshold, cv::noArray(), kIterations, kConfidence);
  return found.empty() ? Homography() : Homography(cv::Matx33d(found));
}

std::vector<Estimator> estimators(const std::vector<std::string>& selectors,
                                  const std::map<std::string, OptionMap>& options) {
  std::vector<Estimator> all;
  for (const std::string& spec : selectors) {
    const auto given = options.find(SelectorSpec::fromText(spec).name);
    const std::shared_ptr<Selector> selector =
        createSelector(spec, given == options.end() ? OptionMap() : given->second);
    all.push_back({spec,
                   [selector](const Correspondences& matches) {
                     const Selection selection = selector->select(matches);
                     return selection.model_kind == ModelKind::kHomography ? Homography(selection.model)
                                                                           : Homography();
                   },
                   {},
                   {}});
  }
  for (const auto& [name, method] : {std::pair{"cv::findHomography, RANSAC", int{cv::RANSAC}},
                                     {"cv::findHomography, USAC_MAGSAC", CORRSEL_USAC(MAGSAC)}}) {
    if (method < 0) {
      std::cout << name << " needs OpenCV 4.5\n";
      continue;
    }
    all.push_back(
        {name, [m = method](const Correspondences& matches) { return findHomography(matches, m); }, {}, {}});
  }
  return all;
}

void print(const std::string& title, const std::vector<Estimator>& all) {
  std::cout << "\n"
            << title << ": corner error, " << all.front().errors.size() << " pairs\n\n"
            << "| estimator | AUC 1 px | AUC 3 px | AUC 5 px | median px | none | median ms |\n"
            << "|---|---|---|---|---|---|---|\n";
  for (const Estimator& estimator : all) {
    const auto none =
        std::count(estimator.errors.begin(), estimator.errors.end(), std::numeric_limits<double>::infinity());
    std::printf("| %s | %.1f | %.1f | %.1f | %.2f | %d | %.2f |\n", estimator.name.c_str(),
                100 * errorAuc(estimator.errors, 1), 100 * errorAuc(estimator.errors, 3),
                100 * errorAuc(estimator.errors, 5), quantile(estimator.errors, 0.5), int(none),
                1000 * quantile(estimator.seconds, 0.5));
  }
  std::fflush(stdout);
}

int run(const corrsel::ArgumentValues& values) {
  const std::string data_root = values.text("data_root"), dataset = values.text("dataset");
  if (data_root.empty()) throw corrsel::UsageError("--data_root is missing: the folder of the datasets");
  std::map<std::string, OptionMap> options;
  parseOptionAssignments(values.text("options"), options);
  const int threads = int(values.number("threads", 1, 1024));
  const auto reader = openDataset(dataset, data_root + "/" + dataset, 0);
  for (const std::string& features : values.list("features")) {
    const auto extractor = createExtractor(features, options);
    std::vector<Estimator> all = estimators(splitSelectors(values.text("selectors")), options);
    for (std::size_t i = 0; i < reader->size(); ++i) {
      const ImagePair pair = reader->read(i);
      if (pair.truth.kind != TruthKind::kHomography) continue;
      const auto [left, right] = extractPair(*extractor, pair.left, pair.right, threads);
      const Correspondences matches = matchFeatures(left, right, MatchOptions(), threads);
      for (Estimator& estimator : all) {
        const Stopwatch watch;
        const Homography found = estimator.estimate(matches);
        estimator.seconds.push_back(watch.seconds());
        estimator.errors.push_back(found ? cornerError(*found, pair.truth.matrix, pair.left.size())
                                         : std::numeric_limits<double>::infinity());
      }
    }
    if (all.front().errors.empty()) {
      throw corrsel::UsageError("dataset '" + dataset + "' has no pair with a homography");
    }
    print(dataset + ", " + features, all);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  corrsel::core::addReferenceSelectors();
  try {
    const corrsel::ArgumentValues values =
        corrsel::parseCommandLine(argumentTable(), {argv + 1, argv + argc});
    if (values.help) {
      std::cout << corrsel::helpText(argumentTable());
      return 0;
    }
    return run(values);
  } catch (const std::exception& error) {
    std::cerr << "homography_quality: " << error.what() << "\n";
    return 2;
  }
}
