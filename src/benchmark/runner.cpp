#include "corrsel/benchmark/runner.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <set>
#include <stdexcept>

#include "corrsel/datasets/reader.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/evaluation/match_drawing.h"
#include "corrsel/features/extractor.h"
#include "corrsel/features/feature_cache.h"
#include "corrsel/features/matcher.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"
#include "corrsel/stopwatch.h"

namespace corrsel::core {
namespace {

constexpr std::size_t kExamplePairs = 6;
constexpr double kExampleTolerance = 5.0;  // px, the paper's tau for its tables
constexpr int kExampleWidth = 1200;        // px
// A sequence's first image stays between its pairs even where every image has 15000 features.
constexpr std::size_t kFeatureCacheBytes = std::size_t{256} << 20U;

/// A selector as the grid uses it: RANSAC-like ones fit the model that the ground truth is of.
struct GridSelector {
  std::string spec;
  std::vector<std::unique_ptr<Selector>> homography, fundamental;  // one per repetition
  const Selector& at(bool use_homography, int repetition) const {
    return *(use_homography ? homography : fundamental)[static_cast<std::size_t>(repetition)];
  }
};

/// Six pairs spread evenly over the run.
std::set<std::size_t> exampleNumbers(std::size_t total) {
  std::set<std::size_t> numbers;
  for (std::size_t k = 0; k < kExamplePairs; ++k) numbers.insert((2 * k + 1) * total / (2 * kExamplePairs));
  return numbers;
}

Correspondences syntheticMatches() {
  Random random(1);
  Correspondences matches;
  matches.left_size = matches.right_size = {640, 480};
  for (int i = 0; i < 500; ++i) {
    const auto x = static_cast<float>(random.uniform(0, 639)), y = static_cast<float>(random.uniform(0, 479));
    const bool inlier = i % 2 == 0;
    matches.add({x, y}, inlier ? cv::Point2f(x * 0.95F + 9, y * 0.97F + 5)
                               : cv::Point2f(static_cast<float>(random.uniform(0, 639)),
                                             static_cast<float>(random.uniform(0, 479))));
    matches.distance.push_back(inlier ? 0.5F : 0.9F);
    matches.second_distance.push_back(1.0F);
  }
  return matches;
}

}  // namespace

/// The putative matches of one pair and what is known about them.
struct BenchmarkRunner::Putative {
  std::string features;
  Correspondences matches;
  std::vector<double> errors;
  std::size_t n_left = 0, n_right = 0;
  double detect_seconds = kUndefined, describe_seconds = kUndefined, match_seconds = kUndefined;

  Putative survivors(const std::vector<std::uint8_t>& mask) const {
    const std::vector<std::uint32_t> rows = selectedRows(mask);
    Putative result{features,       matches.subset(rows), {},           n_left, n_right,
                    detect_seconds, describe_seconds,     match_seconds};
    for (const std::uint32_t row : rows) result.errors.push_back(errors[row]);
    return result;
  }
};

/// Where a selection stands in the grid.
struct BenchmarkRunner::Cell {
  const std::string& preselection;
  const std::string& selector;
  int repetition;
};

struct BenchmarkRunner::Tools {
  std::vector<std::unique_ptr<FeatureExtractor>> extractors;
  FeatureCache features{kFeatureCacheBytes};
  MatchOptions match;
  std::vector<GridSelector> selectors;
  std::unique_ptr<Selector> preselector;
};

BenchmarkRunner::BenchmarkRunner(const BenchmarkConfig& config, RunFolder& folder, RunObserver& observer,
                                 const std::atomic<bool>& stop)
    : config_(config), folder_(folder), observer_(observer), stop_(stop), tools_(std::make_unique<Tools>()) {
  const auto given = [&config](const std::string& name) {
    const auto found = config.options.find(name.substr(0, name.find_first_of(":+")));
    return found == config.options.end() ? OptionMap{} : found->second;
  };
  for (const std::string& name : config.features)
    tools_->extractors.push_back(createExtractor(name, config.options));
  setOptions(tools_->match, given("match"), "match");
  for (const std::string& spec : config.selectors) {
    GridSelector selector;
    selector.spec = spec;
    for (int repetition = 0; repetition < config.repetitions; ++repetition) {
      OptionMap common = {{"seed", std::to_string(config.seed + repetition)},
                          {"threads", std::to_string(config.threads)}};
      common["model"] = "homography";
      selector.homography.push_back(createSelector(spec, given(spec), common));
      common["model"] = "fundamental";
      selector.fundamental.push_back(createSelector(spec, given(spec), common));
    }
    tools_->selectors.push_back(std::move(selector));
  }
  tools_->preselector = createSelector("nnsr", given("nnsr"));
  cv::setNumThreads(config.threads);
}

BenchmarkRunner::~BenchmarkRunner() = default;

void BenchmarkRunner::warmUp() const {
  const Correspondences matches = syntheticMatches();
  for (const GridSelector& selector : tools_->selectors) selector.at(true, 0).select(matches);
  cv::Mat noise(240, 320, CV_8U);
  Random random(2);
  for (auto pixel = noise.begin<std::uint8_t>(); pixel != noise.end<std::uint8_t>(); ++pixel) {
    *pixel = static_cast<std::uint8_t>(random.index(256));
  }
  for (const auto& extractor : tools_->extractors) {
    const auto [left, right] = extractPair(*extractor, noise, noise, config_.threads);
    matchFeatures(left, right, tools_->match, config_.threads);
  }
}

RunState BenchmarkRunner::run(const std::vector<std::unique_ptr<PairSource>>& sources) {
  RunState state;
  const auto limited = [this](std::size_t size) {
    return config_.max_pairs > 0 ? std::min(size, static_cast<std::size_t>(config_.max_pairs)) : size;
  };
  for (const auto& source : sources) state.pairs_total += limited(source->size());
  const std::set<std::size_t> examples = exampleNumbers(state.pairs_total);
  state.pairs_done = folder_.doneCount();
  const ProgressMeter meter(state.pairs_total, state.pairs_done);
  observer_.progress(meter.at(state.pairs_done, ""));
  warmUp();
  std::size_t number = 0;
  for (const auto& source : sources) {
    for (std::size_t i = 0; i < limited(source->size()); ++i, ++number) {
      if (stop_) {
        state.interrupted = true;
        return state;
      }
      ImagePair pair;
      const char* stage = "read";
      try {
        if (!source->next(pair)) break;
        if (folder_.isDone(pair.id)) continue;
        stage = "run";
        runPair(pair, examples.count(number) > 0);
        if (stop_) continue;
        ++state.pairs_done;
      } catch (const RunFolderError&) {
        throw;
      } catch (const std::exception& error) {
        const Failure failure{pair.id, "", stage, error.what()};
        folder_.appendFailure(failure);
        observer_.failed(failure);
        ++state.pairs_failed;
      }
      observer_.progress(meter.at(state.pairs_done, pair.id.text()));
    }
  }
  state.interrupted = stop_;
  return state;
}

std::vector<BenchmarkRunner::Putative> BenchmarkRunner::putativeMatches(const ImagePair& pair) const {
  std::vector<Putative> inputs;
  if (pair.given) {
    Putative putative;
    putative.features = "given";
    putative.matches = *pair.given;
    putative.n_left = putative.n_right = pair.given->size();
    inputs.push_back(std::move(putative));
  } else {
    for (const auto& extractor : tools_->extractors) {
      Putative putative;
      putative.features = extractor->name();
      const auto [left, right] =
          tools_->features.extractPair(*extractor, pair.left, pair.right, config_.threads);
      putative.n_left = left->keypoints.size();
      putative.n_right = right->keypoints.size();
      putative.detect_seconds = left->detect_seconds + right->detect_seconds;
      putative.describe_seconds = left->describe_seconds + right->describe_seconds;
      const Stopwatch watch;
      putative.matches = matchFeatures(*left, *right, tools_->match, config_.threads);
      putative.match_seconds = watch.seconds();
      inputs.push_back(std::move(putative));
    }
  }
  for (Putative& input : inputs) input.errors = groundTruthErrors(pair.truth, input.matches);
  return inputs;
}

std::vector<ResultRow> BenchmarkRunner::judge(const ImagePair& pair, const Putative& putative,
                                              const Cell& cell, const Selection& selection) const {
  EvaluationOptions options;
  options.tolerances = config_.tolerances;
  options.ground_truth_tolerance = config_.ground_truth_tolerance;
  const Evaluation evaluation = evaluate(pair.truth.kind, putative.errors, selection.mask, options);
  std::vector<ResultRow> rows;
  for (const Metrics& metrics : evaluation.metrics) {
    ResultRow row;
    row.id = pair.id;
    row.features = putative.features;
    row.preselection = cell.preselection;
    row.selector = cell.selector;
    row.n_left = putative.n_left;
    row.n_right = putative.n_right;
    row.n_putative = evaluation.n_putative;
    row.n_ground_truth = evaluation.n_ground_truth;
    row.n_selected = evaluation.n_selected;
    row.metrics = metrics;
    row.status = selection.status;
    row.seed = config_.seed + cell.repetition;
    row.detect_seconds = putative.detect_seconds;
    row.describe_seconds = putative.describe_seconds;
    row.match_seconds = putative.match_seconds;
    row.select_seconds = selection.seconds;
    rows.push_back(row);
  }
  return rows;
}

void BenchmarkRunner::drawExample(const ImagePair& pair, const Putative& putative, const Cell& cell,
                                  const Selection& selection) const {
  ExampleImage image;
  image.id = pair.id;
  image.features = putative.features;
  image.preselection = cell.preselection;
  image.selector = cell.selector;
  image.tau = pair.truth.kind == TruthKind::kLabels ? kUndefined : kExampleTolerance;
  for (std::size_t i = 0; i < selection.mask.size(); ++i) {
    if (std::isnan(putative.errors[i])) continue;
    const bool correct = putative.errors[i] <= kExampleTolerance;
    image.n_selected += selection.mask[i];
    image.n_correct += selection.mask[i] && correct ? 1 : 0;
    image.n_missed += !selection.mask[i] && correct ? 1 : 0;
  }
  image.n_wrong = image.n_selected - image.n_correct;
  cv::Mat picture = drawMatches(pair.left, pair.right, putative.matches, selection.mask, putative.errors,
                                kExampleTolerance);
  if (picture.cols > kExampleWidth) {
    cv::resize(picture, picture, {kExampleWidth, picture.rows * kExampleWidth / picture.cols}, 0, 0,
               cv::INTER_AREA);
  }
  folder_.appendImage(image, picture);
}

void BenchmarkRunner::runPair(const ImagePair& pair, bool example) {
  const bool homography = pair.truth.kind == TruthKind::kHomography || pair.truth.kind == TruthKind::kNone;
  const std::vector<Putative> inputs = putativeMatches(pair);
  std::vector<ResultRow> rows;
  for (const Putative& input : inputs) {
    for (const std::string& preselection : config_.preselection) {
      const bool preselect = preselection == "nnsr";
      const Selection preselected = preselect ? tools_->preselector->select(input.matches) : Selection{};
      const bool usable = preselected.status != Status::kUnsupportedInput;
      const Putative putative = preselect && usable ? input.survivors(preselected.mask) : input;
      for (const GridSelector& selector : tools_->selectors) {
        if (preselect && isNnsr(selector.spec)) continue;
        for (int repetition = 0; repetition < config_.repetitions; ++repetition) {
          if (stop_) return;
          const Cell cell{preselection, selector.spec, repetition};
          const Selection selection =
              usable ? selector.at(homography, repetition).select(putative.matches) : preselected;
          const std::vector<ResultRow> judged = judge(pair, putative, cell, selection);
          rows.insert(rows.end(), judged.begin(), judged.end());
          observer_.judged(judged);
          const bool draw = example && &input == &inputs.front() && !preselect && repetition == 0 &&
                            selector.spec != "keep_all" && judged.front().judged();
          if (draw) drawExample(pair, putative, cell, selection);
        }
      }
    }
  }
  folder_.appendPair(rows);
}

}  // namespace corrsel::core
