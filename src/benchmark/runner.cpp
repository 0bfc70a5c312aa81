#include "corrsel/benchmark/runner.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <opencv2/core/utility.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>
#include <stdexcept>

#include "base/progress_meter.h"
#include "base/size_text.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "benchmark/example_images.h"
#include "benchmark/examples.h"
#include "benchmark/feature_cache.h"
#include "benchmark/files.h"
#include "benchmark/pose_rows.h"
#include "benchmark/saved_matches.h"
#include "benchmark/scaling.h"
#include "benchmark/tables.h"
#include "corrsel/benchmark/experiments.h"
#include "corrsel/datasets/reader.h"
#include "corrsel/datasets/scene.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/features/extractor.h"
#include "corrsel/matching/match_drawing.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/random.h"
#include "corrsel/selectors/factory.h"

namespace corrsel::core {
namespace {

constexpr int kExampleWidth = 1000;  // px
// A bag of one's own is one sequence. A wrong declaration of it is reported after these pairs, since the
// whole run would be in vain.
constexpr std::size_t kEarlyPairs = 8;
// Keeps the first image of a sequence between its pairs even where every image has 15000 features.
constexpr std::size_t kFeatureCacheBytes = std::size_t{256} << 20U;

/// A selector of the grid, with the models that BenchmarkConfig::offeredTo() gives it.
struct GridSelector {
  std::string spec;
  std::vector<std::unique_ptr<Selector>> homography, fundamental;  // one per repetition
  const Selector& at(bool use_homography, int repetition) const {
    return *(use_homography ? homography : fundamental)[static_cast<std::size_t>(repetition)];
  }
};

/// The example pairs of the whole run, and up to kExamplesPerDataset more of each dataset.
std::vector<PairId> examplesOf(const std::vector<ResultRow>& rows, double tau) {
  std::vector<PairId> chosen = chooseExamples(rows, tau);
  std::map<std::string, std::vector<ResultRow>> by_dataset;
  for (const ResultRow& row : rows) by_dataset[row.id.dataset].push_back(row);
  for (const auto& [dataset, own] : by_dataset) {
    for (const PairId& id : chooseExamples(own, tau, kExamplesPerDataset)) {
      if (std::find(chosen.begin(), chosen.end(), id) == chosen.end()) chosen.push_back(id);
    }
  }
  return chosen;
}

}  // namespace

/// The putative matches of one pair and what is known about them.
struct BenchmarkRunner::Putative {
  std::string features;
  Correspondences matches;
  std::vector<double> errors;
  std::size_t n_left = 0, n_right = 0;
  double detect_seconds = kUndefined, describe_seconds = kUndefined, match_seconds = kUndefined;
  double extract_wall_seconds = 0;  ///< wall time of detection and description of both images

  Putative survivors(const std::vector<std::uint8_t>& mask) const {
    const std::vector<std::uint32_t> rows = selectedRows(mask);
    Putative result{features,       matches.subset(rows), {},           n_left, n_right,
                    detect_seconds, describe_seconds,     match_seconds};
    for (const std::uint32_t row : rows) result.errors.push_back(errors[row]);
    return result;
  }
};

/// What was noticed in this session, so that it is reported once.
struct Noticed {
  std::set<std::string> texts;
  std::set<std::pair<std::string, int>> bits;  ///< dataset, bits of its images
  std::set<std::string> reduced;               ///< features
};

struct BenchmarkRunner::Tools {
  std::vector<std::unique_ptr<FeatureExtractor>> extractors;
  FeatureCache features{kFeatureCacheBytes};
  MatchOptions match;
  std::vector<GridSelector> selectors;
  std::unique_ptr<Selector> preselector;
  Noticed noticed;
};

BenchmarkRunner::BenchmarkRunner(const BenchmarkConfig& config, RunFolder& folder, RunObserver& observer,
                                 const std::atomic<bool>& stop)
    : config_(config), folder_(folder), observer_(observer), stop_(stop), tools_(std::make_unique<Tools>()) {
  for (const std::string& name : config.features)
    tools_->extractors.push_back(createExtractor(name, config.options));
  setOptions(tools_->match, config.optionsOf("match"), "match");
  for (const std::string& spec : config.selectors) {
    GridSelector selector;
    selector.spec = spec;
    for (int repetition = 0; repetition < config.repetitions; ++repetition) {
      // Selectors keep their one thread, so that their times can be compared.
      selector.homography.push_back(
          createSelector(spec, config.optionsOf(spec), config.offeredTo(spec, true, repetition)));
      selector.fundamental.push_back(
          createSelector(spec, config.optionsOf(spec), config.offeredTo(spec, false, repetition)));
    }
    tools_->selectors.push_back(std::move(selector));
  }
  tools_->preselector = createSelector("nnsr", config.optionsOf("nnsr"));
  cv::setNumThreads(config.threads);
}

BenchmarkRunner::~BenchmarkRunner() = default;

void BenchmarkRunner::warmUp() const {
  SceneSpec scene;
  scene.n = 500;
  const Correspondences matches = makeScene(scene).matches;
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

/// Calls use(source, number) for every pair, up to max_pairs of each source, until the run is to stop.
/// @return number of pairs
template <class Use>
std::size_t BenchmarkRunner::eachPair(const std::vector<std::unique_ptr<PairSource>>& sources,
                                      const Use& use) {
  std::size_t number = 0;
  for (const auto& source : sources) {
    std::size_t size = source->size();
    if (config_.max_pairs > 0) size = std::min(size, static_cast<std::size_t>(config_.max_pairs));
    for (std::size_t i = 0; i < size; ++i, ++number) {
      if (!stop_) use(*source, number);
    }
  }
  return number;
}

void BenchmarkRunner::notice(const Remark& remark) {
  folder_.appendRemark(remark);
  if (tools_->noticed.texts.insert(remark.selector + ": " + remark.text).second) observer_.noticed(remark);
}

/// Notices what is done to the images before features are searched.
void BenchmarkRunner::noticeImages(const ImagePair& pair) {
  Noticed& noticed = tools_->noticed;
  if (pair.stretched && noticed.bits.emplace(pair.id.dataset, pair.stretched->bits).second) {
    notice({pair.id.dataset, "", "", pair.stretched->text()});
  }
  if (pair.given) return;
  struct Reduction {
    std::vector<std::string> features, limits;
  };
  for (const auto& [image, side] : {std::pair{&pair.left, "left"}, std::pair{&pair.right, "right"}}) {
    std::map<int, Reduction> reductions;  // by width
    for (const auto& extractor : tools_->extractors) {
      const int width = extractor->searchedSize(image->size()).width;
      if (width == image->cols || !noticed.reduced.insert(extractor->name()).second) continue;
      reductions[width].features.push_back(extractor->name());
      reductions[width].limits.push_back(extractor->options().front().first + ".max_megapixels");
    }
    for (const auto& [width, reduction] : reductions) {
      const std::string factor = formatNumber(std::round(100.0 * image->cols / width) / 100);
      const std::string size = sizeText(image->size());
      notice({"", "", "",
              "large images are reduced before the features " + joinList(reduction.features, " and ") +
                  " are found in them: the " + side + " image of " + pair.id.text() + " (" + size +
                  " px) to a width of " + std::to_string(width) + " px, by a factor of " + factor +
                  "; the limit is the option " + joinList(reduction.limits, " and ")});
    }
  }
}

void BenchmarkRunner::recordFailure(const PairId& id, const char* stage, const std::string& error) {
  const Failure failure{id, "", stage, error};
  folder_.appendFailure(failure);
  observer_.failed(failure);
}

/// Reports what is doubtful about the last sequence where it has ended, that is, where the next pair belongs
/// to another one, and also after its first pairs.
void BenchmarkRunner::reportTruth(const PairId& next) {
  if (sequence_checks_.empty()) return;
  const PairId& last = sequence_checks_.back().id;
  const bool ended = last.dataset != next.dataset || last.sequence != next.sequence;
  const bool early = sequence_pairs_ == kEarlyPairs;
  if (!ended && !early) return;
  for (const TruthWarning& warning : truthWarnings(sequence_checks_)) observer_.doubtful(warning);
  if (!ended) return;
  sequence_checks_.clear();
  sequence_pairs_ = 0;
}

RunState BenchmarkRunner::run(const std::vector<std::unique_ptr<PairSource>>& sources, const Shard& shard) {
  RunState state;
  state.shard = shard.text();
  state.pairs_done = folder_.doneCount();
  eachPair(sources, [&](PairSource&, std::size_t number) { state.pairs_total += shard.holds(number); });
  const ProgressMeter meter(state.pairs_total, state.pairs_done);
  observer_.progress(meter.at(state.pairs_done, ""));
  warmUp();
  eachPair(sources, [&](PairSource& source, std::size_t number) {
    const std::optional<PairId> known = source.nextId();
    if (known && (!shard.holds(number) || folder_.isDone(*known))) return source.skip();
    ImagePair pair;
    if (known) pair.id = *known;
    const char* stage = "read";
    try {
      const Stopwatch watch;
      if (!source.next(pair)) throw DatasetError("the data end before this pair");
      if (!shard.holds(number) || folder_.isDone(pair.id)) return;
      stage = "run";
      reportTruth(pair.id);
      noticeImages(pair);
      runPair(pair, number, watch.seconds());
      if (stop_) return;
      ++state.pairs_done;
    } catch (const RunFolderError&) {
      throw;
    } catch (const std::exception& error) {
      if (!shard.holds(number)) return;
      recordFailure(pair.id, stage, error.what());
      ++state.pairs_failed;
    }
    observer_.progress(meter.at(state.pairs_done, pair.id.text()));
  });
  reportTruth({});
  state.interrupted = stop_;
  return state;
}

/// @param features  name of an extractor, or kGivenFeatures
BenchmarkRunner::Putative BenchmarkRunner::putativeMatches(const ImagePair& pair,
                                                           const std::string& features) const {
  Putative putative;
  putative.features = features;
  if (features == kGivenFeatures) {
    putative.matches = *pair.given;
    putative.n_left = putative.n_right = pair.given->size();
    pair.addCamerasTo(putative.matches);
    return putative;
  }
  for (const auto& extractor : tools_->extractors) {
    if (extractor->name() != features) continue;
    const Stopwatch extraction;
    const auto [left, right] =
        tools_->features.extractPair(*extractor, pair.left, pair.right, config_.threads);
    putative.extract_wall_seconds = extraction.seconds();
    putative.n_left = left->keypoints.size();
    putative.n_right = right->keypoints.size();
    putative.detect_seconds = left->detect_seconds + right->detect_seconds;
    putative.describe_seconds = left->describe_seconds + right->describe_seconds;
    const Stopwatch watch;
    putative.matches = matchFeatures(*left, *right, tools_->match, config_.threads);
    putative.match_seconds = watch.seconds();
    pair.addCamerasTo(putative.matches);
  }
  return putative;
}

const Selector& BenchmarkRunner::selectorFor(const ImagePair& pair, std::size_t selector,
                                             int repetition) const {
  const TruthKind kind = pair.truth.kind;
  const bool homography =
      kind == TruthKind::kHomography || kind == TruthKind::kRotation || kind == TruthKind::kNone;
  return tools_->selectors[selector].at(homography, repetition);
}

ResultRow BenchmarkRunner::resultRow(const ImagePair& pair, const Putative& putative, const Cell& cell,
                                     const std::string& selector, int repetition,
                                     const Selection& selection) const {
  EvaluationOptions options;
  options.tolerances = config_.tolerances;
  options.ground_truth_tolerance = config_.ground_truth_tolerance;
  const Evaluation evaluation = evaluate(pair.truth.kind, putative.errors, selection.mask, options);
  ResultRow row;
  row.id = pair.id;
  row.features = cell.features;
  row.preselection = cell.preselection;
  row.selector = selector;
  row.truth = pair.truth.kind;
  row.n_left = putative.n_left;
  row.n_right = putative.n_right;
  row.n_putative = evaluation.n_putative;
  row.n_ground_truth = evaluation.n_ground_truth;
  row.n_selected = evaluation.n_selected;
  row.metrics = evaluation.metrics;
  row.status = selection.status;
  row.scene = selection.scene;
  row.confidence = selection.confidence;
  row.seed = config_.seed + repetition;
  row.detect_seconds = putative.detect_seconds;
  row.describe_seconds = putative.describe_seconds;
  row.match_seconds = putative.match_seconds;
  row.select_seconds = selection.seconds;
  return row;
}

PoseRow BenchmarkRunner::poseRow(const ImagePair& pair, const Putative& putative, const Cell& cell,
                                 const std::string& selector, int repetition,
                                 const Selection& selection) const {
  cv::Size left_size;
  if (estimatesHomographies(config_)) {
    left_size = pair.left.empty() ? putative.matches.left_size : pair.left.size();
  }
  PoseRow row = measurePose(pair.truth, left_size, putative.matches, selection);
  row.id = pair.id;
  row.features = cell.features;
  row.preselection = cell.preselection;
  row.selector = selector;
  row.seed = config_.seed + repetition;
  return row;
}

/// What the estimators make of all ground-truth inliers.
PoseRow BenchmarkRunner::groundTruthPose(const ImagePair& pair, const Putative& putative,
                                         const Cell& cell) const {
  Selection inliers;
  for (const double error : putative.errors) {
    inliers.mask.push_back(error <= config_.ground_truth_tolerance ? 1 : 0);
  }
  return poseRow(pair, putative, cell, kGroundTruthSelection, 0, inliers);
}

/// What the run of one pair has produced so far.
struct BenchmarkRunner::PairRun {
  PairRun(const ImagePair& image_pair, const BenchmarkConfig& config, const std::string& folder)
      : pair(image_pair), with_poses(hasPoseRows(image_pair.truth, config)) {
    if (config.save_matches) saved.emplace(folder, pair, config.repetitions > 1);
  }

  template <class Measure>
  void addPose(const Measure& measure) {
    if (!with_poses) return;
    const Stopwatch watch;
    poses.push_back(measure());
    pose_seconds += watch.seconds();
  }

  std::vector<StageTime> stages(double read_seconds) const {
    const double evaluate_seconds =
        total.seconds() - extract_seconds - match_seconds - select_seconds - pose_seconds;
    std::vector<StageTime> times = {{"read", read_seconds},
                                    {"features", extract_seconds},
                                    {"match", match_seconds},
                                    {"select", select_seconds},
                                    {"evaluate", evaluate_seconds}};
    if (with_poses) times.push_back({kPoseStage, pose_seconds});
    return times;
  }

  const ImagePair& pair;
  const bool with_poses;
  const Stopwatch total;
  double extract_seconds = 0, match_seconds = 0, select_seconds = 0, pose_seconds = 0;
  std::vector<ResultRow> rows;
  std::vector<PoseRow> poses;
  std::vector<TruthCheck> checks;
  std::optional<SavedMatches> saved;
};

/// Runs all selectors on the putative matches that a preselection leaves. @return false if the run was
/// stopped
bool BenchmarkRunner::runCell(const Cell& cell, const Putative& input, PairRun& run) {
  const ImagePair& pair = run.pair;
  const bool preselect = cell.preselection == "nnsr";
  const Selection preselected = preselect ? tools_->preselector->select(input.matches) : Selection{};
  run.select_seconds += preselected.seconds;
  const bool usable = preselected.status != Status::kUnsupportedInput;
  if (!usable) notice({pair.id.dataset, "", "preselection by " + cell.preselection, preselected.message});
  const Putative putative = preselect && usable ? input.survivors(preselected.mask) : input;
  if (run.saved) run.saved->writePutative(cell, putative.matches);
  for (std::size_t k = 0; k < tools_->selectors.size(); ++k) {
    const std::string& spec = tools_->selectors[k].spec;
    if (preselect && isNnsr(spec)) continue;
    for (int repetition = 0; repetition < config_.repetitions; ++repetition) {
      if (stop_) return false;
      Selection selection = usable ? selectorFor(pair, k, repetition).select(putative.matches) : preselected;
      run.select_seconds += selection.seconds;
      if (selection.status == Status::kUnsupportedInput && usable)
        notice({pair.id.dataset, "", spec, selection.message});
      addConfidence(putative.matches, selection);
      run.rows.push_back(resultRow(pair, putative, cell, spec, repetition, selection));
      run.addPose([&] { return poseRow(pair, putative, cell, spec, repetition, selection); });
      observer_.evaluated(run.rows.back());
      if (run.saved) run.saved->write(putative.matches, spec, config_.seed + repetition, selection);
    }
  }
  run.addPose([&] { return groundTruthPose(pair, putative, cell); });
  return true;
}

void BenchmarkRunner::runPair(const ImagePair& pair, std::size_t number, double read_seconds) {
  PairRun run(pair, config_, folder_.path());
  for (const std::string& features :
       pair.given ? std::vector<std::string>{kGivenFeatures} : config_.features) {
    Putative input = putativeMatches(pair, features);
    run.extract_seconds += input.extract_wall_seconds;
    run.match_seconds += std::isnan(input.match_seconds) ? 0 : input.match_seconds;
    input.errors = groundTruthErrors(pair.truth, input.matches);
    // The readings differ in the truth and not in the features, so those of the first features suffice.
    if (run.checks.empty()) {
      run.checks = checkTruth(pair.truth, pair.other_readings, input.matches);
      for (TruthCheck& check : run.checks) {
        check.id = pair.id;
        check.features = features;
      }
    }
    for (const std::string& preselection : config_.preselectionsOf(features)) {
      if (!runCell({features, preselection}, input, run)) return;
    }
  }
  folder_.appendPair(run.rows, number, run.stages(read_seconds), run.checks, run.poses,
                     run.saved ? run.saved->selections() : std::vector<SavedSelection>());
  sequence_checks_.insert(sequence_checks_.end(), run.checks.begin(), run.checks.end());
  if (!run.checks.empty()) ++sequence_pairs_;
}

void BenchmarkRunner::timeSelectors() {
  const std::string file = (std::filesystem::path(folder_.path()) / scalingTable().file()).string();
  if (!config_.measuresScaling() || std::filesystem::exists(file)) return;
  observer_.progress(ProgressMeter(1, 0).at(0, "timing the selectors on generated matches"));
  const Stopwatch watch;
  const std::vector<ScalingRow> rows = measureScaling(config_, stop_);
  if (rows.empty()) return;
  writeFile(file, scalingTable().text(rows));
  folder_.appendStage({"scaling", watch.seconds()});
}

void BenchmarkRunner::drawExamples(const std::vector<std::unique_ptr<PairSource>>& sources) {
  if (makesVariants(config_.experiment)) return;
  const Cell first = config_.grid().front();
  std::vector<ResultRow> rows;
  const double tau = config_.tableTolerance();
  folder_.forEachRow([&](const ResultRow& row) {
    const bool drawn = row.features == kGivenFeatures || row.features == first.features;
    if (drawn && row.metricsAt(tau) != nullptr && row.preselection == first.preselection &&
        row.seed == config_.seed)
      rows.push_back(row);
  });
  const std::vector<PairId> chosen = examplesOf(rows, tau);
  const auto isChosen = [&chosen](const PairId& id) {
    return std::find(chosen.begin(), chosen.end(), id) != chosen.end();
  };
  std::set<std::string> wanted, there;
  for (const ResultRow& row : rows) {
    // keep_all, too: its picture shows the matches before selection.
    if (row.evaluated() && isChosen(row.id)) wanted.insert(row.id.text() + "/" + row.selector);
  }
  for (const ExampleImage& image : readExampleImages(folder_.path()))
    there.insert(image.id.text() + "/" + image.selector);
  if (wanted == there) return;
  clearExampleImages(folder_.path());
  const Stopwatch watch;
  const ProgressMeter meter(chosen.size(), 0);
  std::size_t drawn = 0;
  eachPair(sources, [&](PairSource& source, std::size_t) {
    const std::optional<PairId> known = source.nextId();
    if (known && !isChosen(*known)) return source.skip();
    ImagePair pair;
    if (known) pair.id = *known;
    try {
      if (drawn == chosen.size() || !source.next(pair) || !isChosen(pair.id)) return;
      Cell cell = first;
      if (pair.given) cell.features = kGivenFeatures;
      Putative putative = putativeMatches(pair, cell.features);
      putative.errors = groundTruthErrors(pair.truth, putative.matches);
      if (cell.preselection == "nnsr")
        putative = putative.survivors(tools_->preselector->select(putative.matches).mask);
      for (std::size_t k = 0; k < tools_->selectors.size(); ++k) {
        const std::string& spec = tools_->selectors[k].spec;
        if (stop_ || wanted.count(pair.id.text() + "/" + spec) == 0) continue;
        drawExample(pair, putative, cell, spec, selectorFor(pair, k, 0).select(putative.matches));
      }
      observer_.progress(meter.at(++drawn, "pictures of " + pair.id.text()));
    } catch (const RunFolderError&) {
      throw;
    } catch (const std::exception& error) {
      if (isChosen(pair.id)) recordFailure(pair.id, "pictures", error.what());
    }
  });
  folder_.appendStage({"pictures", watch.seconds()});
}

void BenchmarkRunner::drawExample(const ImagePair& pair, const Putative& putative, const Cell& cell,
                                  const std::string& selector, const Selection& selection) {
  const double tolerance = config_.tableTolerance();
  ExampleImage image;
  image.id = pair.id;
  image.features = cell.features;
  image.preselection = cell.preselection;
  image.selector = selector;
  image.tau = pair.truth.kind == TruthKind::kLabels ? kUndefined : tolerance;
  for (std::size_t i = 0; i < selection.mask.size(); ++i) {
    if (std::isnan(putative.errors[i])) continue;
    const bool correct = putative.errors[i] <= tolerance;
    image.n_selected += selection.mask[i];
    image.n_correct += selection.mask[i] && correct ? 1 : 0;
    image.n_missed += !selection.mask[i] && correct ? 1 : 0;
  }
  image.n_wrong = image.n_selected - image.n_correct;
  constexpr std::size_t kLines = 200;
  cv::Mat picture = drawMatches(pair.left, pair.right, putative.matches, selection.mask, putative.errors,
                                tolerance, kLines, selection.group);
  if (picture.cols > kExampleWidth) {
    cv::resize(picture, picture, {kExampleWidth, picture.rows * kExampleWidth / picture.cols}, 0, 0,
               cv::INTER_AREA);
  }
  appendExampleImage(folder_.path(), image, picture);
}

}  // namespace corrsel::core
