#include "corrsel/evaluation/truth_check.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include "base/text.h"
#include "corrsel/evaluation/errors.h"
#include "corrsel/random.h"
#include "geometry/homography.h"

namespace corrsel::core {
namespace {

constexpr double kFarMore = 2;     // times as many matches
constexpr double kDeviations = 5;  // that a difference exceeds what chance explains
constexpr char kExchangedAxes[] = "exchanged_axes", kUnitSquare[] = "unit_square", kTranspose[] = "transpose";

/// How a reading is described to people.
struct Wording {
  const char *name, *counted, *mistake;
};

constexpr Wording kWordings[] = {
    {"inverse", "with the inverse", "the matrix probably maps from right to left"},
    {kTranspose, "with the transpose", ""},  // mistakeOf()
    {"inverse_transpose", "with the transpose of the inverse",
     "the matrix probably maps from right to left and is written column by column"},
    {kExchangedAxes, "with x and y exchanged", "the matrix is probably one of coordinates (row, column)"},
    {kUnitSquare, "with coordinates from 0 to 1",
     "the matrix is probably one of coordinates that were divided by width and height"},
    {"opposite_sign", "with the opposite sign", "the disparity is probably right x minus left x"},
    {"right_image", "as the disparity of the right image",
     "the disparity probably belongs to the right image"},
    {"sixteenths", "divided by 16", "the disparity is probably in sixteenths of a pixel"},
    {"256ths", "divided by 256", "the disparity is probably in 256ths of a pixel"},
    {"raw", "with the images taken as raw",
     "the images are probably raw and were declared rectified: set images to raw"},
    {"rectified", "with the images taken as rectified",
     "the images are probably rectified and were declared raw: set images to rectified"},
};

// For a reading that another source of pairs has named.
constexpr Wording kOtherWording = {"", "in another reading",
                                   "the pairs are probably not what they were declared to be"};

const Wording& wordingOf(const std::string& reading) {
  const auto* const found = std::find_if(std::begin(kWordings), std::end(kWordings),
                                         [&](const Wording& wording) { return wording.name == reading; });
  return found == std::end(kWordings) ? kOtherWording : *found;
}

std::string mistakeOf(const TruthCheck& counts) {
  if (counts.reading != kTranspose) return wordingOf(counts.reading).mistake;
  return counts.kind == TruthKind::kHomography
             ? "the matrix is probably written column by column"
             : "the matrix probably belongs to the images in the opposite order";
}

/// As a part of "agree with the homography"; plural for several pairs.
std::string nameOf(TruthKind kind, bool several) {
  switch (kind) {
    case TruthKind::kHomography:
      return several ? "the homographies" : "the homography";
    case TruthKind::kFundamental:
      return several ? "the fundamental matrices" : "the fundamental matrix";
    case TruthKind::kEssential:
      return several ? "the essential matrices" : "the essential matrix";
    case TruthKind::kRotation:
      return several ? "the rotations" : "the rotation";
    default:
      return several ? "the disparities" : "the disparity";
  }
}

OtherReading reading(const char* name, const GroundTruth& truth) {
  OtherReading result;
  result.name = name;
  result.truth = truth;
  return result;
}

OtherReading withMatrix(const char* name, const GroundTruth& truth, const cv::Matx33d& matrix) {
  OtherReading result = reading(name, truth);
  result.truth.matrix = matrix;
  return result;
}

OtherReading withDisparity(const char* name, const GroundTruth& truth, double factor) {
  OtherReading result = reading(name, truth);
  // An expression assigned to the member would be written into the pixels that it shares with `truth`.
  const cv::Mat scaled = truth.disparity * factor;
  result.truth.disparity = scaled;
  return result;
}

/// The readings of a matrix that is not of pixel coordinates (x, y).
void addCoordinates(const GroundTruth& truth, const Correspondences& matches,
                    std::vector<OtherReading>& readings) {
  const cv::Matx33d exchange(0, 1, 0, 1, 0, 0, 0, 0, 1);
  readings.push_back(withMatrix(kExchangedAxes, truth, exchange * truth.matrix * exchange));
  if (matches.left_size.empty() || matches.right_size.empty()) return;
  const auto scaled = [](double x, double y) { return cv::Matx33d(x, 0, 0, 0, y, 0, 0, 0, 1); };
  const cv::Size2d left = matches.left_size, right = matches.right_size;
  const bool homography = truth.kind == TruthKind::kHomography;
  const cv::Matx33d to_right = homography ? scaled(right.width, right.height)  // x' of F stands on the left
                                          : scaled(1 / right.width, 1 / right.height);
  readings.push_back(
      withMatrix(kUnitSquare, truth, to_right * truth.matrix * scaled(1 / left.width, 1 / left.height)));
}

Correspondences exchangedImages(const Correspondences& matches) {
  Correspondences result = matches;
  std::swap(result.left_x, result.right_x);
  std::swap(result.left_y, result.right_y);
  return result;
}

std::vector<OtherReading> readingsOf(const GroundTruth& truth, const Correspondences& matches) {
  std::vector<OtherReading> readings;
  switch (truth.kind) {
    case TruthKind::kHomography: {
      const cv::Matx33d inverse = adjugateOf(truth.matrix);
      readings = {withMatrix("inverse", truth, inverse), withMatrix(kTranspose, truth, truth.matrix.t()),
                  withMatrix("inverse_transpose", truth, inverse.t())};
      addCoordinates(truth, matches, readings);
      break;
    }
    case TruthKind::kFundamental:
      readings = {withMatrix(kTranspose, truth, truth.matrix.t())};
      addCoordinates(truth, matches, readings);
      break;
    case TruthKind::kDisparity: {
      // A point at x in the right image is at x + d in the left one.
      OtherReading right_image = withDisparity("right_image", truth, -1);
      right_image.moved = exchangedImages;
      readings = {withDisparity("opposite_sign", truth, -1), right_image,
                  withDisparity("sixteenths", truth, 1.0 / 16), withDisparity("256ths", truth, 1.0 / 256)};
      break;
    }
    case TruthKind::kEssential:
      readings = {withMatrix(kTranspose, truth, truth.matrix.t())};
      break;
    case TruthKind::kRotation:
      readings = {withMatrix("inverse", truth, truth.matrix.t())};
      break;
    case TruthKind::kLabels:
    case TruthKind::kNone:
      break;
  }
  return readings;
}

/// The matches with their right points in random order. Those that agree with a reading now do so by chance.
Correspondences shuffled(const Correspondences& matches) {
  Correspondences result;
  result.left_x = matches.left_x;
  result.left_y = matches.left_y;
  result.right_x = matches.right_x;
  result.right_y = matches.right_y;
  result.left_size = matches.left_size;
  result.right_size = matches.right_size;
  result.left_camera = matches.left_camera;
  result.right_camera = matches.right_camera;
  Random random(0);
  for (std::size_t i = result.size(); i > 1; --i) {
    const std::size_t j = random.index(static_cast<std::uint32_t>(i));
    std::swap(result.right_x[i - 1], result.right_x[j]);
    std::swap(result.right_y[i - 1], result.right_y[j]);
  }
  return result;
}

std::size_t countWithin(const GroundTruth& truth, const Correspondences& matches, double tolerance) {
  const std::vector<double> errors = groundTruthErrors(truth, matches);
  return static_cast<std::size_t>(
      std::count_if(errors.begin(), errors.end(), [&](double error) { return error <= tolerance; }));
}

bool explainsFarMore(const TruthCheck& counts) {
  const auto number = [](std::size_t count) { return static_cast<double>(count); };
  const double truth = std::max(0.0, number(counts.n_truth) - number(counts.n_truth_by_chance));
  const double reading = number(counts.n_reading) - number(counts.n_reading_by_chance);
  const double variance = number(counts.n_truth) + number(counts.n_truth_by_chance) +
                          number(counts.n_reading) + number(counts.n_reading_by_chance);
  return reading > 0 && reading >= kFarMore * truth && reading - truth >= kDeviations * std::sqrt(variance);
}

/// The readings of a sequence or of a pair, each with the sums of its counts and the number of its pairs.
class Sums {
 public:
  void add(const TruthCheck& check) {
    const auto same = [&](const auto& sum) {
      return sum.counts.kind == check.kind && sum.counts.reading == check.reading;
    };
    auto found = std::find_if(sums_.begin(), sums_.end(), same);
    if (found == sums_.end()) {
      sums_.push_back({{}, 1, check});
      return;
    }
    ++found->pairs;
    found->counts.n_putative += check.n_putative;
    found->counts.n_truth += check.n_truth;
    found->counts.n_reading += check.n_reading;
    found->counts.n_truth_by_chance += check.n_truth_by_chance;
    found->counts.n_reading_by_chance += check.n_reading_by_chance;
  }

  /// Appends the reading that explains the most, if it explains far more than the truth. @return whether
  bool check(const PairId& id, std::vector<TruthWarning>& warnings) const {
    const TruthWarning* best = nullptr;
    for (const TruthWarning& sum : sums_) {
      if (!explainsFarMore(sum.counts)) continue;
      if (best == nullptr || sum.counts.n_reading > best->counts.n_reading) best = &sum;
    }
    if (best == nullptr) return false;
    warnings.push_back(*best);
    warnings.back().id = id;
    return true;
  }

 private:
  std::vector<TruthWarning> sums_;
};

}  // namespace

std::vector<TruthCheck> checkTruth(const GroundTruth& truth, const std::vector<OtherReading>& other_readings,
                                   const Correspondences& matches) {
  std::vector<OtherReading> readings = readingsOf(truth, matches);
  readings.insert(readings.end(), other_readings.begin(), other_readings.end());
  std::vector<TruthCheck> checks;
  if (readings.empty() || matches.empty()) return checks;
  const Correspondences chance = shuffled(matches);
  TruthCheck check;
  check.kind = truth.kind;
  check.n_putative = matches.size();
  for (const OtherReading& other : readings) {
    check.reading = other.name;
    check.tolerance = other.tolerance;
    check.n_truth = countWithin(truth, matches, other.tolerance);
    check.n_truth_by_chance = countWithin(truth, chance, other.tolerance);
    const Correspondences moved = other.moved ? other.moved(matches) : Correspondences();
    check.n_reading = countWithin(other.truth, other.moved ? moved : matches, other.tolerance);
    check.n_reading_by_chance =
        countWithin(other.truth, other.moved ? shuffled(moved) : chance, other.tolerance);
    checks.push_back(check);
  }
  return checks;
}

std::vector<TruthWarning> truthWarnings(const std::vector<TruthCheck>& checks) {
  std::map<PairId, Sums> sequences, pairs;  // a sequence is a pair without its name
  for (const TruthCheck& check : checks) {
    sequences[{check.id.dataset, check.id.sequence, ""}].add(check);
    pairs[check.id].add(check);
  }
  std::vector<TruthWarning> warnings;
  for (const auto& [sequence, sums] : sequences) {
    if (sums.check(sequence, warnings)) continue;
    for (auto pair = pairs.lower_bound(sequence); pair != pairs.end(); ++pair) {
      if (pair->first.dataset != sequence.dataset || pair->first.sequence != sequence.sequence) break;
      pair->second.check(pair->first, warnings);
    }
  }
  return warnings;
}

std::string TruthWarning::text() const {
  const std::string name = id.dataset + "/" + id.sequence + (id.pair.empty() ? "" : "/" + id.pair);
  return name + ": " + std::to_string(counts.n_truth) + " of " + std::to_string(counts.n_putative) +
         " putative matches agree with " + nameOf(counts.kind, pairs > 1) + " within " +
         formatNumber(counts.tolerance) + " px, " + std::to_string(counts.n_reading) + " " +
         wordingOf(counts.reading).counted + "; " + mistakeOf(counts);
}

}  // namespace corrsel::core
