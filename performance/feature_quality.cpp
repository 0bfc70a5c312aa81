// Compares the quality of features: repeatability, inliers and F of selections; see
// docs/evaluation.md.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <opencv2/core/utility.hpp>

#include "base/parallel.h"
#include "base/text.h"
#include "corrsel/benchmark/config.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/metrics.h"
#include "corrsel/evaluation/statistics.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/reference/reference_selectors.h"
#include "corrsel/selectors/factory.h"
#include "evaluation/repeatability.h"
#include "programs/command_line.h"

namespace {

using namespace corrsel::core;

const corrsel::CommandLineTable& argumentTable() {
  static const corrsel::CommandLineTable table = {
      "feature_quality",
      "Compares the quality of features on the image pairs of datasets with homographies, and prints tables "
      "in Markdown.",
      {},
      {
          {"data_root", "FOLDER", "", "folder that holds the folders of the datasets"},
          {"dataset", "NAMES", "vgg,symbench", "datasets, comma-separated"},
          {"features", "LIST", "sift+sift=cv_sift+cv_sift,orb+orb=cv_orb+cv_orb,hessian_affine+sift",
           "features, comma-separated; A=B compares A with B"},
          {"max_features", "N", "2000",
           "also measured with this limit, and of A=B with as many features; 0 = not"},
          {"selectors", "LIST", "usac,gms,lpm", "selectors whose F is measured"},
          {"options", "LIST", "", "options of the algorithms: sift.contrast_threshold=0.03,..."},
          {"threads", "N", "2", "threads that extract and match"},
          {"pairs", "", "", "print a row for every pair as well"},
      },
      "exit code: 0 = no mean of an A is more than 0.5 points below that of its B, 1 = one is, 2 = wrong "
      "arguments\n"};
  return table;
}

constexpr double kTolerance = 5;  // px, of inliers and of F
// A selector that draws samples finds the model of a hard pair with some seeds only: with one seed, the mean
// over 40 pairs would jump by 2.5 points for every such pair.
constexpr int kSeeds = 10;
constexpr double kMaxLoss = 0.5;             // percentage points
constexpr double kMaxSurplus = 0.1;          // share of features by which two numbers count as equal
constexpr double kMaxDistance = 0.5;         // px, between the positions of one feature
constexpr double kMaxScaleDifference = 0.1;  // share

/// The pairs of a dataset; every image is there once.
struct Dataset {
  struct Pair {
    PairId id;
    GroundTruth truth;
    std::size_t left, right;  // numbers of images
  };
  std::vector<cv::Mat> images;
  std::vector<Pair> pairs;

  std::size_t add(const cv::Mat& image) {
    const auto same = [&image](const cv::Mat& other) {
      return other.size() == image.size() && other.type() == image.type() &&
             std::equal(image.datastart, image.dataend, other.datastart, other.dataend);
    };
    const auto found = std::find_if(images.begin(), images.end(), same);
    if (found != images.end()) return std::size_t(found - images.begin());
    images.push_back(image.clone());
    return images.size() - 1;
  }
};

Dataset readAll(const std::string& name, const std::string& data_root) {
  const auto reader = openDataset(name, data_root + "/" + name);
  Dataset result;
  for (std::size_t i = 0; i < reader->size(); ++i) {
    const ImagePair pair = reader->read(i);
    if (pair.truth.kind != TruthKind::kHomography) {
      throw std::invalid_argument("the pair " + pair.id.text() +
                                  " has no homography; needed: a dataset of planes");
    }
    result.pairs.push_back({pair.id, pair.truth, result.add(pair.left), result.add(pair.right)});
  }
  return result;
}

/// The measures of one pair, in percent except for the numbers of features. NaN: undefined for this pair.
struct Quality {
  double features, repeatability, right;
  std::vector<double> f;  // by selector
};

/// The strongest features.
Features strongest(const Features& all, std::size_t number) {
  Features result = all;
  if (result.keypoints.size() <= number) return result;
  result.keypoints.resize(number);
  result.frames.resize(number);
  result.descriptors = result.descriptors.rowRange(0, int(number)).clone();
  return result;
}

Quality measure(const Dataset::Pair& pair, const Features& left, const Features& right,
                const std::vector<std::string>& selectors) {
  Quality result{};
  result.features = double(left.keypoints.size() + right.keypoints.size()) / 2;
  result.repeatability =
      100 *
      repeatability(left.frames, left.image_size, right.frames, right.image_size, pair.truth.matrix).share();
  const Correspondences matches = matchFeatures(left, right);
  const std::vector<double> errors = groundTruthErrors(pair.truth, matches);
  const auto right_matches =
      std::count_if(errors.begin(), errors.end(), [](double error) { return error <= kTolerance; });
  result.right = matches.empty() ? kUndefined : 100 * double(right_matches) / double(matches.size());
  EvaluationOptions options;
  options.tolerances = {kTolerance};
  for (const std::string& name : selectors) {
    std::vector<double> f;  // by seed
    for (int seed = 0; seed < kSeeds; ++seed) {
      const auto selector = createSelector(
          name, {}, {{"model", "homography"}, {"threads", "1"}, {"seed", std::to_string(seed)}});
      const Evaluation evaluation =
          evaluate(pair.truth.kind, errors, selector->select(matches).mask, options);
      f.push_back(100 * evaluation.metrics[0].f_paper);
    }
    result.f.push_back(mean(f));
  }
  return result;
}

using FeatureSets = std::vector<Features>;  // one per image

FeatureSets extractAll(const Dataset& dataset, const std::string& name, const AlgorithmOptions& options,
                       int threads) {
  const auto extractor = createExtractor(name, options);
  FeatureSets result(dataset.images.size());
  forEachBlock(result.size(), 1, threads, [&](std::size_t begin, std::size_t) {
    result[begin] = extractor->extract(dataset.images[begin]);
  });
  return result;
}

std::vector<Quality> measureAll(const Dataset& dataset, const FeatureSets& features,
                                const std::vector<std::string>& selectors, int threads) {
  std::vector<Quality> result(dataset.pairs.size());
  forEachBlock(result.size(), 1, threads, [&](std::size_t begin, std::size_t) {
    const Dataset::Pair& pair = dataset.pairs[begin];
    result[begin] = measure(pair, features[pair.left], features[pair.right], selectors);
  });
  return result;
}

/// Both sets with as many features of each image as the smaller one has.
void equalize(FeatureSets& a, FeatureSets& b) {
  for (std::size_t i = 0; i < a.size(); ++i) {
    const std::size_t number = std::min(a[i].keypoints.size(), b[i].keypoints.size());
    a[i] = strongest(a[i], number);
    b[i] = strongest(b[i], number);
  }
}

/// Values in the order of the table's columns.
std::vector<double> values(const Quality& q) {
  std::vector<double> result = {q.features, q.repeatability, q.right};
  result.insert(result.end(), q.f.begin(), q.f.end());
  return result;
}

/// Means over the pairs for which a value is defined, for every column.
std::vector<double> means(const std::vector<Quality>& all) {
  std::vector<double> result;
  for (std::size_t column = 0; column < values(all.front()).size(); ++column) {
    std::vector<double> defined;
    for (const Quality& quality : all) {
      if (const double value = values(quality)[column]; !std::isnan(value)) defined.push_back(value);
    }
    result.push_back(mean(defined));
  }
  return result;
}

std::string text(double value, const char* format) {
  if (std::isnan(value)) return "-";
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

void printHeader(const std::vector<std::string>& selectors) {
  std::vector<std::string> names = {"dataset", "limit", "features", "number", "repeatability", "inliers"};
  for (const std::string& selector : selectors) names.push_back("F " + selector);
  names.emplace_back("");
  std::cout << "| " << joinList(names, " | ") << " |\n|---|---|---|" << std::flush;
  for (std::size_t i = 3; i < names.size(); ++i) std::cout << "--:|";
  std::cout << std::endl;
}

void printRow(const std::string& dataset, const std::string& limit, const std::string& name,
              const std::vector<double>& numbers, const char* format, const std::string& verdict) {
  std::cout << "| " << dataset << " | " << limit << " | " << name << " | "
            << text(numbers[0], *format == '%' && format[1] == '+' ? "%+.0f" : "%.0f");
  for (std::size_t i = 1; i < numbers.size(); ++i) std::cout << " | " << text(numbers[i], format);
  std::cout << " | " << verdict << " |" << std::endl;
}

struct Arguments {
  std::string data_root;
  std::vector<std::string> datasets, features, selectors;
  int max_features, threads;
  bool pairs;
  AlgorithmOptions options;
};

class Comparison {
 public:
  Comparison(const Arguments& arguments, const std::string& name, const Dataset& dataset)
      : arguments_(arguments), name_(name), dataset_(dataset) {}

  /// Prints the rows of `features`, which is A or A=B.
  void run(const std::string& features) {
    const std::size_t equal = features.find('=');
    const std::string first = features.substr(0, equal);
    if (equal == std::string::npos) {
      row("default", first, extract(first, 0));
      if (arguments_.max_features > 0) row(limit(), first, extract(first, arguments_.max_features));
      return;
    }
    const std::string second = features.substr(equal + 1);
    FeatureSets a = extract(first, 0), b = extract(second, 0);
    rows("default", first, second, a, b);
    faithful_.push_back("| " + name_ + " | " + first + " | " + second + " | " +
                        text(agreementOf(a, b), "%.1f") + " | " + text(agreementOf(b, a), "%.1f") + " |");
    equalize(a, b);
    rows("as many", first, second, a, b);
    if (arguments_.max_features == 0) return;
    a = extract(first, arguments_.max_features);
    b = extract(second, arguments_.max_features);
    rows(limit(), first, second, a, b);
  }

  bool passed() const { return passed_; }
  const std::vector<std::string>& faithful() const { return faithful_; }

 private:
  std::string limit() const { return std::to_string(arguments_.max_features); }

  FeatureSets extract(const std::string& features, int limit) const {
    AlgorithmOptions options = arguments_.options;
    if (limit > 0) options[algorithmsOf(features).front()]["max_features"] = std::to_string(limit);
    return extractAll(dataset_, features, options, arguments_.threads);
  }

  std::vector<double> row(const std::string& limit, const std::string& features, const FeatureSets& sets) {
    const std::vector<Quality> all = measureAll(dataset_, sets, arguments_.selectors, arguments_.threads);
    for (std::size_t i = 0; arguments_.pairs && i < all.size(); ++i) {
      printRow(dataset_.pairs[i].id.text(), limit, features, values(all[i]), "%.1f", "");
    }
    printRow(name_, limit, features, means(all), "%.2f", "");
    return means(all);
  }

  void rows(const std::string& limit, const std::string& first, const std::string& second,
            const FeatureSets& a, const FeatureSets& b) {
    const std::vector<double> ours = row(limit, first, a), theirs = row(limit, second, b);
    std::vector<double> difference;
    for (std::size_t i = 0; i < ours.size(); ++i) difference.push_back(ours[i] - theirs[i]);
    const double surplus = std::abs(difference[0]) / theirs[0];
    // With other numbers of features, the values cannot be compared.
    const bool comparable = surplus <= kMaxSurplus;
    const bool good = std::all_of(difference.begin() + 1, difference.end(),
                                  [](double value) { return !(value < -kMaxLoss); });
    printRow(name_, limit, "difference", difference, "%+.2f",
             comparable ? good ? "PASS" : "**FAIL**" : "other number");
    passed_ = passed_ && (good || !comparable);
  }

  /// Mean over the left images of the share of the features of `a` that `b` has too, in percent.
  double agreementOf(const FeatureSets& a, const FeatureSets& b) const {
    std::vector<std::size_t> images;
    for (const Dataset::Pair& pair : dataset_.pairs) images.push_back(pair.left);
    std::sort(images.begin(), images.end());
    images.erase(std::unique(images.begin(), images.end()), images.end());
    std::vector<double> shares;
    for (const std::size_t image : images) {
      const double share = agreement(a[image].frames, b[image].frames, kMaxDistance, kMaxScaleDifference);
      if (!std::isnan(share)) shares.push_back(100 * share);
    }
    return mean(shares);
  }

  const Arguments& arguments_;
  std::string name_;
  const Dataset& dataset_;
  bool passed_ = true;
  std::vector<std::string> faithful_;
};

int run(const Arguments& arguments) {
  cv::setNumThreads(1);
  bool passed = true;
  std::vector<std::string> faithful;
  printHeader(arguments.selectors);
  for (const std::string& name : arguments.datasets) {
    const Dataset dataset = readAll(name, arguments.data_root);
    Comparison comparison(arguments, name, dataset);
    for (const std::string& features : arguments.features) comparison.run(features);
    passed = passed && comparison.passed();
    faithful.insert(faithful.end(), comparison.faithful().begin(), comparison.faithful().end());
  }
  if (!faithful.empty()) {
    std::cout << "\nFeatures of A for which B has one within " << kMaxDistance << " px and "
              << 100 * kMaxScaleDifference << " % of scale, and the reverse, percent, on the left images:\n\n"
              << "| dataset | A | B | of A's | of B's |\n|---|---|---|--:|--:|\n";
    for (const std::string& line : faithful) std::cout << line << "\n";
  }
  return passed ? 0 : 1;
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
    Arguments arguments;
    arguments.data_root = values.text("data_root");
    if (arguments.data_root.empty())
      throw corrsel::UsageError("--data_root is missing: the folder of the datasets");
    arguments.datasets = values.list("dataset");
    arguments.features = values.list("features");
    arguments.selectors = values.list("selectors");
    arguments.max_features = int(values.number("max_features", 0, 100000));
    arguments.threads = int(values.number("threads", 1, 1024));
    arguments.pairs = values.isOn("pairs");
    parseOptionAssignments(values.text("options"), arguments.options);
    return run(arguments);
  } catch (const std::exception& error) {
    std::cerr << "feature_quality: " << error.what() << "\n";
    return 2;
  }
}
