#include "features/parts/dog_keypoints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/parallel.h"
#include "features/parts/orientation_histogram.h"
#include "features/parts/quadratic_fit.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr int kBorder = 5;    // pixels of the octave without keypoints
constexpr int kMaxSteps = 5;  // of the refinement
constexpr double kFar =
    2.5;  // from a pixel to the extremum of its quadratic, which is meaningless from here on
constexpr float kTwoPi = 6.283185307F;
constexpr double kUnit = 255.0 * kGreyUnit;  // of pixels, per unit of contrast

/// Gaussian weights of the offsets first..last from a pixel, for a centre at `shift` from it. Ratios of
/// neighbours are a geometric sequence.
void windowWeights(int first, int last, float shift, float sigma, float* weights) {
  const float scale = -0.5F / (sigma * sigma);
  const float start = std::exp(scale * shift * shift), square = std::exp(2 * scale);
  float weight = start, ratio = std::exp(scale * (1 - 2 * shift));
  for (int k = 0; k <= last; ++k) {
    if (k >= first) weights[k - first] = weight;
    weight *= ratio;
    ratio *= square;
  }
  weight = start;
  ratio = std::exp(scale * (1 + 2 * shift));
  for (int k = 0; k >= first; --k) {
    if (k <= last) weights[k - first] = weight;
    weight *= ratio;
    ratio *= square;
  }
}

}  // namespace

namespace {

/// A pixel of the differences of Gaussians of an octave.
struct Place {
  std::int32_t x, y;
  std::int16_t octave, level;

  std::uint64_t number() const {
    return static_cast<std::uint64_t>(octave) << 56 | static_cast<std::uint64_t>(level) << 48 |
           static_cast<std::uint64_t>(y) << 24 | static_cast<std::uint64_t>(x);
  }
};

struct PlacedKeypoint {
  DogKeypoint keypoint;
  Place place;
};

enum class Step { kDropped, kMoved, kDone };

/// One step of the refinement: moves `place` or makes a keypoint of it.
/// @param pixels  pixels(level, dy) is the pixel of a level at the place's column, dy rows below the place
template <class Pixels>
Step refine(const ScaleOctave& octave, const DogOptions& options, const Pixels& pixels, Place& place,
            DogKeypoint& keypoint) {
  const std::int16_t* near[4][3];
  for (int level = 0; level < 4; ++level) {
    for (int dy = -1; dy <= 1; ++dy) near[level][dy + 1] = pixels(place.level + level - 1, dy);
  }
  const QuadraticFit fit = fitQuadratic([&near](int dl, int dy, int dx) {
    return static_cast<double>(near[dl + 2][dy + 1][dx] - near[dl + 1][dy + 1][dx]);
  });
  if (!fit.solved || !(fit.reach() < kFar)) return Step::kDropped;
  if (fit.reach() >= 0.5) {
    const auto moved = [&fit](int axis) { return static_cast<int>(std::lround(fit.offset[axis])); };
    place.x += moved(0);
    place.y += moved(1);
    const int level = place.level + moved(2);
    if (level < 1 || level > options.octave_layers || place.x < kBorder ||
        place.x >= octave.width - kBorder || place.y < kBorder || place.y >= octave.height - kBorder) {
      return Step::kDropped;
    }
    place.level = static_cast<std::int16_t>(level);
    return Step::kMoved;
  }
  const double value = std::abs(fit.extremum()) / kUnit, trace = fit.trace(), area = fit.determinant();
  const double e = options.edge_threshold;
  if (value * options.octave_layers < options.contrast_threshold || !(area > 0) ||
      trace * trace * e >= (e + 1) * (e + 1) * area) {
    return Step::kDropped;
  }
  const double scale = octave.levels[0].step, start = octave.levels[0].offset;
  const double layer = place.level + fit.offset[2];
  keypoint.x = static_cast<float>(start + (place.x + fit.offset[0]) * scale);
  keypoint.y = static_cast<float>(start + (place.y + fit.offset[1]) * scale);
  keypoint.sigma = static_cast<float>(options.sigma * std::exp2(layer / options.octave_layers) * scale);
  keypoint.response = static_cast<float>(value);
  keypoint.layer = static_cast<float>(layer);
  keypoint.octave = place.octave;
  keypoint.level = place.level;
  return Step::kDone;
}

}  // namespace

/// Searches every row of the scale space for extrema as soon as it is computed.
class DogKeypoints::Search : public ScaleRowVisitor {
 public:
  Search(const DogOptions& options, const PlaceMask& mask)
      : options_(options), layers_(options.octave_layers), mask_(mask) {
    const double contrast = std::floor(0.5 * options.contrast_threshold / options.octave_layers * 255);
    threshold_ = static_cast<std::int16_t>(contrast * kGreyUnit);
  }

  void begin(const ScaleOctave& octave, int bands) override {
    collect();
    if (bands_.size() < static_cast<std::size_t>(bands)) bands_.resize(static_cast<std::size_t>(bands));
    for (Band& band : bands_) {
      band.next = -1;
      band.strip = -1;
    }
    stride_ = octave.levels[0].stride;
    ++octave_;
  }

  void visit(const ScaleOctave& octave, const ScaleRows& rows, int y) override {
    if (y < kBorder || y >= octave.height - kBorder) return;
    Band& band = bands_[static_cast<std::size_t>(rows.band())];
    if (y / kTile != band.strip) setRuns(octave, y / kTile, band);
    if (band.runs.empty()) return;
    const auto size = static_cast<std::size_t>(stride_) * 3 * static_cast<std::size_t>(layers_ + 2);
    if (band.rows.size() < size) band.rows.resize(size);
    band.extrema.resize(static_cast<std::size_t>(octave.width) * static_cast<std::size_t>(layers_));
    const auto row = [&](int layer, int at) {
      return band.rows.data() + (std::ptrdiff_t{layer} * 3 + at % 3) * stride_;
    };
    const ScaleSpaceKernels& kernel = kernels().scale_space;
    for (int at = std::max(band.next, y - 1); at <= y + 1; ++at) {
      for (int layer = 0; layer < layers_ + 2; ++layer) {
        const auto level = static_cast<std::size_t>(layer);
        kernel.subtractRows(rows(level, at), rows(level + 1, at), octave.width, row(layer, at));
      }
    }
    band.next = y + 2;
    std::array<const std::int16_t*, std::size_t{3} * (ScaleSpaceKernels::kMaxLevels + 2)> near;
    for (int k = 0; k < 3 * (layers_ + 2); ++k) near[static_cast<std::size_t>(k)] = row(k / 3, y + k % 3 - 1);
    for (const auto& [first, last] : band.runs) {
      const int n = kernel.extrema(near.data(), layers_, first, last, threshold_, band.extrema.data());
      std::sort(band.extrema.begin(), band.extrema.begin() + n,
                [](const ExtremumPlace& a, const ExtremumPlace& b) {
                  return a.column != b.column ? a.column < b.column : a.level < b.level;
                });
      for (int k = 0; k < n; ++k) {
        const ExtremumPlace& extremum = band.extrema[static_cast<std::size_t>(k)];
        const int x = extremum.column;
        PlacedKeypoint found;
        found.place = {x, y, octave_, static_cast<std::int16_t>(extremum.level)};
        const Step step = refine(
            octave, options_,
            [&](int level, int dy) { return rows(static_cast<std::size_t>(level), y + dy) + x; }, found.place,
            found.keypoint);
        if (step == Step::kDone) band.found.push_back(found);
        if (step == Step::kMoved) band.moved.push_back(found.place);
      }
    }
  }

  /// The keypoints in the order of their places.
  void finish(const ScaleSpace& space, int threads, std::vector<DogKeypoint>& keypoints) {
    collect();
    // The rows of those that move may not have been computed when they were found.
    constexpr std::size_t kBlock = 64;
    std::vector<std::vector<PlacedKeypoint>> blocks((moved_.size() + kBlock - 1) / kBlock);
    forEachBlock(moved_.size(), kBlock, threads, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        PlacedKeypoint found;
        if (settle(space, moved_[i], found)) blocks[begin / kBlock].push_back(found);
      }
    });
    for (const auto& block : blocks) found_.insert(found_.end(), block.begin(), block.end());
    // Extrema that move to the same pixel are one keypoint.
    std::vector<std::pair<std::uint64_t, std::size_t>> order;
    order.reserve(found_.size());
    for (std::size_t i = 0; i < found_.size(); ++i) order.emplace_back(found_[i].place.number(), i);
    std::sort(order.begin(), order.end());
    keypoints.clear();
    for (std::size_t i = 0; i < order.size(); ++i) {
      if (i > 0 && order[i].first == order[i - 1].first) continue;
      const DogKeypoint& keypoint = found_[order[i].second].keypoint;
      if (mask_.allows({keypoint.x, keypoint.y})) keypoints.push_back(keypoint);
    }
  }

 private:
  static constexpr int kTile = 16;

  struct Band {
    std::vector<std::int16_t> rows;  // of the differences: three per layer
    std::vector<ExtremumPlace> extrema;
    std::vector<std::pair<int, int>> runs;  // of columns in which the mask allows keypoints
    int strip, next;
    std::vector<PlacedKeypoint> found;
    std::vector<Place> moved;
  };

  /// Refines an extremum that has moved to another pixel. Returns whether it becomes a keypoint.
  bool settle(const ScaleSpace& space, const Place& start, PlacedKeypoint& found) const {
    const ScaleOctave& octave = space.octaves()[static_cast<std::size_t>(start.octave)];
    found.place = start;
    Step step = Step::kMoved;
    for (int k = 1; k < kMaxSteps && step == Step::kMoved; ++k) {
      const Place at = found.place;
      step = refine(
          octave, options_,
          [&](int level, int dy) {
            const ScaleLevel& pixels = octave.levels[static_cast<std::size_t>(level)];
            return pixels.pixels + (at.y + dy) * pixels.stride + at.x;
          },
          found.place, found.keypoint);
    }
    return step == Step::kDone;
  }

  void collect() {
    for (Band& band : bands_) {
      found_.insert(found_.end(), band.found.begin(), band.found.end());
      moved_.insert(moved_.end(), band.moved.begin(), band.moved.end());
      band.found.clear();
      band.moved.clear();
    }
  }

  void setRuns(const ScaleOctave& octave, int strip, Band& band) const {
    band.strip = strip;
    band.runs.clear();
    const int end = octave.width - kBorder;
    if (mask_.everywhere()) {
      if (end > kBorder) band.runs.emplace_back(kBorder, end);
      return;
    }
    const double step = octave.levels[0].step;
    for (int x = kBorder / kTile * kTile; x < end; x += kTile) {
      // The refinement moves an extremum by less than kFar in every step.
      constexpr int kReach = static_cast<int>(kFar * kMaxSteps) + 1;
      const auto low = [step](int at) { return static_cast<int>(std::floor((at - kReach) * step)); };
      const auto high = [step](int at) { return static_cast<int>(std::ceil((at + kReach) * step)) + 1; };
      const cv::Point first(low(x), low(strip * kTile)), last(high(x + kTile), high((strip + 1) * kTile));
      if (!mask_.allowsAny({first, last})) continue;
      const int from = std::max(x, kBorder), to = std::min(x + kTile, end);
      if (!band.runs.empty() && band.runs.back().second == from) {
        band.runs.back().second = to;
      } else {
        band.runs.emplace_back(from, to);
      }
    }
  }

  const DogOptions& options_;
  int layers_;
  const PlaceMask& mask_;
  std::int16_t threshold_;
  std::int16_t octave_ = -1;
  std::ptrdiff_t stride_ = 0;
  std::vector<Band> bands_;
  std::vector<PlacedKeypoint> found_;
  std::vector<Place> moved_;
};

void prefetch(const ScaleLevel& level, double x, double y, double reach) {
  constexpr int kLine = 32;  // pixels of a cache line
  const auto at = [&level](double place, int size) {
    return static_cast<int>(std::clamp((place - level.offset) / level.step, 0.0, size - 1.0));
  };
  const int left = at(x - reach, level.width), right = at(x + reach, level.width);
  const int last = at(y + reach, level.height);
  for (int row = at(y - reach, level.height); row <= last; ++row) {
    const std::int16_t* const pixels = level.pixels + row * level.stride;
    for (int column = left; column < right + kLine; column += kLine) {
      __builtin_prefetch(pixels + std::min(column, right));
    }
  }
}

void DogKeypoints::find(const cv::Mat& image, const DogOptions& options, const PlaceMask& mask, int threads) {
  ScaleSpaceOptions space;
  space.first_octave = options.first_octave;
  space.resolution = options.octave_layers;
  space.last_level = options.octave_layers + 2;
  space.sigma = options.sigma;
  space.min_side = 2 * kBorder + 1;
  Search search(options, mask);
  space_.compute(image, space, threads, &search);
  search.finish(space_, threads, keypoints_);
}

void DogKeypoints::directions(const DogKeypoint& keypoint, std::vector<float>& angles) const {
  using Histogram = OrientationHistogram<float>;
  constexpr float kWindow = 1.5F, kPeak = 0.8F;
  constexpr int kLanes = OrientationKernels::kLanes;
  angles.clear();
  const ScaleLevel& level = levelOf(keypoint);
  const auto step = static_cast<float>(level.step), offset = static_cast<float>(level.offset);
  const float x = (keypoint.x - offset) / step, y = (keypoint.y - offset) / step;
  const float window = kWindow * keypoint.sigma / step;
  const int radius = static_cast<int>(std::lround(3 * window));
  const int cx = static_cast<int>(std::lround(x)), cy = static_cast<int>(std::lround(y));
  const int left = std::max(1 - cx, -radius), right = std::min(level.width - 2 - cx, radius);
  const int top = std::max(1 - cy, -radius), bottom = std::min(level.height - 2 - cy, radius);
  if (left > right || top > bottom) return;
  const int columns = right - left + 1;
  std::array<float, 64> few;
  std::vector<float> many;
  const std::size_t room = static_cast<std::size_t>(columns + kLanes + bottom - top + 1);
  float* across = few.data();
  if (room > few.size()) {
    many.resize(room);
    across = many.data();
  }
  float* const down = across + columns + kLanes;
  windowWeights(left, right, x - static_cast<float>(cx), window, across);
  std::fill(across + columns, down, 0.0F);
  windowWeights(top, bottom, y - static_cast<float>(cy), window, down);
  Histogram histogram;
  kernels().orientation.histogram(level.pixels + (cy + top) * level.stride + cx + left, level.stride, columns,
                                  bottom - top + 1, across, down, histogram.bins());
  histogram.smooth(1,
                   [](const auto& at) { return (at(-2) + at(2) + 4 * (at(-1) + at(1)) + 6 * at(0)) / 16; });
  const float min_height = kPeak * histogram.highest().here;
  histogram.forEachPeak([&](const Histogram::Peak& peak) {
    if (peak.here < min_height) return;
    const float turn = (static_cast<float>(peak.bin) + peak.offset()) / Histogram::kBins;
    angles.push_back((turn < 0 ? turn + 1 : turn >= 1 ? turn - 1 : turn) * kTwoPi);
  });
}

}  // namespace corrsel::core
