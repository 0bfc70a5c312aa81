// Fits the weights of the probabilities of matches, and measures how well these are calibrated; see
// docs/selectors.md.
#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <numeric>
#include <string>
#include <vector>

#include "base/text.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/selectors/factory.h"
#include "geometry/residual.h"
#include "posterior/match_probability.h"
#include "programs/command_line.h"
#include "search/ordering.h"

namespace {

using namespace corrsel::core;

constexpr double kTolerance = 5;  // px, of a right match unless the dataset is given another one
constexpr int kBins = 10;

const corrsel::CommandLineTable& argumentTable() {
  static const corrsel::CommandLineTable table = {
      "train_probability",
      "Fits the weights of the probabilities of matches, prints them as a source file, and reports the "
      "calibration.",
      {},
      {
          {"data_root", "FOLDER", "", "folder that holds the folders of the datasets"},
          {"dataset", "NAMES", "vgg,symbench,kitti_raw,kitti_stereo=3,strecha_dev,adelaidermf",
           "datasets, comma-separated; NAME=PX: matches are right up to this error, 5 px without it"},
          {"features", "NAMES", "sift+sift,orb+orb", "features, for datasets without matches"},
          {"csv", "FILE", "", "file to write the calibration to"},
      },
      ""};
  return table;
}

/// What is known about a match, with and without the model of its answer, and whether it is right.
struct Sample {
  ProbabilityTerms with_model, without_model;
  bool selected;  ///< something is; otherwise the probability is 0
  bool modelled;
  bool right;
};

struct Dataset {
  std::string name;
  double tolerance;  // px
  std::vector<Sample> samples;
};

/// Adds the matches of a pair with the answer of `auto`.
void addMatches(const Correspondences& matches, const GroundTruth& truth, Dataset& dataset) {
  const Selection selection = createSelector("auto")->select(matches);
  const std::vector<double> right_errors = groundTruthErrors(truth, matches);
  std::vector<std::uint32_t> rows(matches.size()), best_first;
  std::iota(rows.begin(), rows.end(), 0U);
  Ordering ordering;
  if (!ordering.byQuality(matches, rows, best_first)) best_first = rows;
  LocalSupport support;
  support.compute(matches, best_first);
  std::vector<double> errors;
  if (selection.model_kind != ModelKind::kNone) {
    errors.resize(matches.size());
    pixelErrors(
        selection.model_kind == ModelKind::kHomography ? Residual::kSmallerTransfer : Residual::kSampson,
        selection.model, matches, errors.data());
  }
  const AnsweredMatches answered = {
      matches, support, selection.mask, selection.model_kind, selection.model, selection.confidence};
  AnsweredMatches plain = answered;
  plain.kind = ModelKind::kNone;
  const AnswerTerms terms(answered, errors), plain_terms(plain, errors);
  for (std::size_t i = 0; i < matches.size(); ++i) {
    dataset.samples.push_back({terms.of(i), plain_terms.of(i), selection.n_selected > 0,
                               selection.model_kind != ModelKind::kNone,
                               right_errors[i] <= dataset.tolerance});
  }
}

Dataset readDataset(const std::string& entry, const std::string& data_root,
                    const std::vector<std::string>& features) {
  const std::size_t equal = entry.find('=');
  Dataset dataset;
  dataset.name = entry.substr(0, equal);
  dataset.tolerance =
      equal == std::string::npos ? kTolerance : parseNumber(entry.substr(equal + 1), "dataset");
  const auto reader = openDataset(dataset.name, data_root + "/" + dataset.name);
  for (std::size_t i = 0; i < reader->size(); ++i) {
    const ImagePair pair = reader->read(i);
    if (pair.given) {
      addMatches(*pair.given, pair.truth, dataset);
      continue;
    }
    for (const std::string& name : features) {
      const auto extractor = createExtractor(name);
      addMatches(matchFeatures(extractor->extract(pair.left), extractor->extract(pair.right)), pair.truth,
                 dataset);
    }
  }
  return dataset;
}

/// Where the images come from: "kitti" for kitti_raw and kitti_stereo.
std::string sourceOf(const Dataset& dataset) { return dataset.name.substr(0, dataset.name.find('_')); }

using DatasetPointers = std::vector<const Dataset*>;

/// Logistic regression by Newton's method. Weights of terms that are 0 everywhere are 0.
ProbabilityTerms fit(const DatasetPointers& datasets, const ProbabilityTerms Sample::*terms) {
  using Vector = Eigen::Matrix<double, kProbabilityTerms, 1>;
  using Matrix = Eigen::Matrix<double, kProbabilityTerms, kProbabilityTerms>;
  constexpr double kRidge = 1e-3;
  constexpr int kSteps = 30;
  ProbabilityTerms weights{};
  for (int step = 0; step < kSteps; ++step) {
    Vector gradient = -kRidge * Eigen::Map<const Vector>(weights.data());
    Matrix curvature = kRidge * Matrix::Identity();
    for (const Dataset* dataset : datasets) {
      for (const Sample& sample : dataset->samples) {
        if (!sample.selected || (terms == &Sample::with_model && !sample.modelled)) continue;
        const Eigen::Map<const Vector> x((sample.*terms).data());
        const double p = probabilityOf(sample.*terms, weights);
        gradient += ((sample.right ? 1 : 0) - p) * x;
        curvature.noalias() += p * (1 - p) * x * x.transpose();
      }
    }
    Eigen::Map<Vector>(weights.data()) += curvature.ldlt().solve(gradient);
  }
  return weights;
}

struct Weights {
  ProbabilityTerms with_model, without_model;
};

Weights fit(const DatasetPointers& datasets) {
  return {fit(datasets, &Sample::with_model), fit(datasets, &Sample::without_model)};
}

/// A probability, and whether its match is right.
struct Prediction {
  double probability;
  bool right;
};

void addPredictions(const Dataset& dataset, const Weights& weights, std::vector<Prediction>& predictions) {
  for (const Sample& sample : dataset.samples) {
    const double p = !sample.selected  ? 0
                     : sample.modelled ? probabilityOf(sample.with_model, weights.with_model)
                                       : probabilityOf(sample.without_model, weights.without_model);
    predictions.push_back({p, sample.right});
  }
}

double logLoss(const std::vector<Prediction>& predictions) {
  constexpr double kLeast = 1e-9;
  double sum = 0;
  for (const Prediction& each : predictions)
    sum -= std::log(std::max(each.right ? each.probability : 1 - each.probability, kLeast));
  return sum / static_cast<double>(predictions.size());
}

/// The lowest log loss of a prediction with two values: the shares of right matches on both sides of any
/// threshold on the probability.
double bestThreshold(std::vector<Prediction> predictions) {
  std::sort(predictions.begin(), predictions.end(),
            [](const Prediction& a, const Prediction& b) { return a.probability < b.probability; });
  const auto loss = [](double right, double n) {
    const auto part = [n](double count) { return count > 0 ? -count * std::log(count / n) : 0; };
    return part(right) + part(n - right);
  };
  double all = 0, below = 0;
  for (const Prediction& each : predictions) all += each.right ? 1 : 0;
  const auto n = static_cast<double>(predictions.size());
  double best = loss(all, n);
  for (std::size_t i = 0; i + 1 < predictions.size(); ++i) {
    below += predictions[i].right ? 1 : 0;
    const auto count = static_cast<double>(i + 1);
    best = std::min(best, loss(below, count) + loss(all - below, n - count));
  }
  return best / n;
}

/// Rows of the calibration: by bins, and around 0.9.
std::vector<std::string> calibration(const std::string& name, const std::vector<Prediction>& predictions) {
  std::vector<std::string> rows;
  for (int bin = 0; bin <= kBins; ++bin) {
    const double low = bin < kBins ? bin / double(kBins) : 0.85,
                 high = bin < kBins ? low + 1.0 / kBins : 0.95;
    double n = 0, mean = 0, right = 0;
    for (const Prediction& each : predictions) {
      if (each.probability < low || (each.probability >= high && high < 1)) continue;
      ++n;
      mean += each.probability;
      right += each.right ? 1 : 0;
    }
    char text[80];
    std::snprintf(text, sizeof text, n > 0 ? "%.2f,%.2f,%.0f,%.3f,%.3f" : "%.2f,%.2f,%.0f,,", low, high, n,
                  mean / n, right / n);
    rows.push_back(name + "," + text);
  }
  return rows;
}

void report(const std::string& name, const std::vector<Prediction>& predictions,
            std::vector<std::string>& table) {
  std::cerr << name << ": log loss " << logLoss(predictions) << ", of the best threshold "
            << bestThreshold(predictions) << "\n";
  const std::vector<std::string> rows = calibration(name, predictions);
  for (const std::string& row : rows) std::cerr << "  " << row << "\n";
  table.insert(table.end(), rows.begin(), rows.end());
}

std::string source(const Weights& weights) {
  const auto list = [](const ProbabilityTerms& values) {
    std::vector<std::string> texts;
    for (const double value : values) texts.push_back(formatNumber(std::round(100 * value) / 100 + 0.0));
    return joinList(texts, ", ");
  };
  return "// Generated by scripts/maintenance/train_probability.sh; do not edit.\n\n"
         "#include \"posterior/probability_weights.h\"\n\nnamespace corrsel::core {\n\n// clang-format off\n"
         "const ProbabilityTerms kWeightsWithModel = {" +
         list(weights.with_model) + "};\nconst ProbabilityTerms kWeightsWithoutModel = {" +
         list(weights.without_model) + "};\n// clang-format on\n\n}  // namespace corrsel::core\n";
}

void train(const corrsel::ArgumentValues& values) {
  std::vector<Dataset> datasets;
  for (const std::string& entry : values.list("dataset"))
    datasets.push_back(readDataset(entry, values.text("data_root"), values.list("features")));
  DatasetPointers all;
  for (const Dataset& dataset : datasets) all.push_back(&dataset);
  const Weights weights = fit(all);
  std::cout << source(weights);

  std::vector<std::string> table;
  std::vector<Prediction> together, left_out;
  for (const Dataset& dataset : datasets) {
    std::vector<Prediction> own;
    addPredictions(dataset, weights, own);
    report(dataset.name, own, table);
    together.insert(together.end(), own.begin(), own.end());
    DatasetPointers others;
    for (const Dataset* other : all)
      if (sourceOf(*other) != sourceOf(dataset)) others.push_back(other);
    if (!others.empty()) addPredictions(dataset, fit(others), left_out);
  }
  report("all", together, table);
  std::vector<std::string> not_written;
  report("all, each with the weights of the others", left_out, not_written);
  if (values.text("csv").empty()) return;
  std::ofstream file(values.text("csv"));
  file << "dataset,low,high,matches,mean_probability,share_right\n";
  for (const std::string& row : table) file << row << "\n";
  if (!file.flush()) throw std::runtime_error("cannot write " + values.text("csv"));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const corrsel::ArgumentValues values =
        corrsel::parseCommandLine(argumentTable(), {argv + 1, argv + argc});
    if (values.help) {
      std::cout << corrsel::helpText(argumentTable());
      return 0;
    }
    if (values.text("data_root").empty())
      throw corrsel::UsageError("--data_root is missing: the folder of the datasets");
    train(values);
    return 0;
  } catch (const std::exception& error) {
    std::cerr << "train_probability: " << error.what() << "\n";
    return 2;
  }
}
