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

struct DogKeypoints::Extremum {
  std::int32_t x, y;
  std::int16_t octave, level;
};

/// Searches every row of the scale space for extrema as soon as it is computed.
class DogKeypoints::Search : public ScaleRowVisitor {
 public:
  Search(const DogOptions& options, const PlaceMask& mask) : layers_(options.octave_layers), mask_(mask) {
    const double contrast = std::floor(0.5 * options.contrast_threshold / options.octave_layers * 255);
    threshold_ = static_cast<std::int16_t>(contrast * kGreyUnit);
  }

  void begin(const ScaleOctave& octave, int bands) override {
    collect();
    if (bands_.size() < static_cast<std::size_t>(bands)) bands_.resize(static_cast<std::size_t>(bands));
    const std::ptrdiff_t stride = octave.levels[0].stride;
    for (Band& band : bands_) {
      band.rows.resize(static_cast<std::size_t>(stride) * 3 * static_cast<std::size_t>(layers_ + 2));
      band.columns.resize(static_cast<std::size_t>(octave.width));
      band.next = -1;
      band.strip = -1;
    }
    ++octave_;
  }

  void visit(const ScaleOctave& octave, const ScaleRows& rows, int y) override {
    if (y < kBorder || y >= octave.height - kBorder) return;
    Band& band = bands_[static_cast<std::size_t>(rows.band())];
    if (y / kTile != band.strip) setRuns(octave, y / kTile, band);
    if (band.runs.empty()) return;
    const std::ptrdiff_t stride = octave.levels[0].stride;
    const auto row = [&](int layer, int at) {
      return band.rows.data() + (std::ptrdiff_t{layer} * 3 + at % 3) * stride;
    };
    const ScaleSpaceKernels& kernel = kernels().scale_space;
    for (int at = std::max(band.next, y - 1); at <= y + 1; ++at) {
      for (int layer = 0; layer < layers_ + 2; ++layer) {
        const auto level = static_cast<std::size_t>(layer);
        kernel.subtractRows(rows(level, at), rows(level + 1, at), octave.width, row(layer, at));
      }
    }
    band.next = y + 2;
    for (int layer = 1; layer <= layers_; ++layer) {
      std::array<const std::int16_t*, 9> near;
      for (int k = 0; k < 9; ++k) near[static_cast<std::size_t>(k)] = row(layer + k / 3 - 1, y + k % 3 - 1);
      for (const auto& [first, last] : band.runs) {
        const int n = kernel.extrema(near.data(), first, last, threshold_, band.columns.data());
        for (int k = 0; k < n; ++k) {
          band.found.push_back(
              {band.columns[static_cast<std::size_t>(k)], y, octave_, static_cast<std::int16_t>(layer)});
        }
      }
    }
  }

  const std::vector<Extremum>& found() {
    collect();
    return found_;
  }

 private:
  static constexpr int kTile = 16;

  struct Band {
    std::vector<std::int16_t> rows;  // of the differences: three per layer
    std::vector<std::int32_t> columns;
    std::vector<std::pair<int, int>> runs;  // of columns in which the mask allows keypoints
    int strip, next;
    std::vector<Extremum> found;
  };

  void collect() {
    for (Band& band : bands_) {
      found_.insert(found_.end(), band.found.begin(), band.found.end());
      band.found.clear();
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
      // The refinement moves an extremum by at most one pixel per step.
      const auto low = [step](int at) { return static_cast<int>(std::floor((at - kMaxSteps - 1) * step)); };
      const auto high = [step](int at) {
        return static_cast<int>(std::ceil((at + kMaxSteps + 1) * step)) + 1;
      };
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

  int layers_;
  const PlaceMask& mask_;
  std::int16_t threshold_;
  std::int16_t octave_ = -1;
  std::vector<Band> bands_;
  std::vector<Extremum> found_;
};

bool DogKeypoints::refine(const Extremum& extremum, const DogOptions& options, DogKeypoint& keypoint,
                          std::uint64_t& place) const {
  const ScaleOctave& octave = space_.octaves()[static_cast<std::size_t>(extremum.octave)];
  const std::ptrdiff_t stride = octave.levels[0].stride;
  int x = extremum.x, y = extremum.y, level = extremum.level;
  for (int step = 0; step < kMaxSteps; ++step) {
    std::array<const std::int16_t*, 4> at;
    for (int k = 0; k < 4; ++k) {
      at[static_cast<std::size_t>(k)] =
          octave.levels[static_cast<std::size_t>(level + k - 1)].pixels + y * stride + x;
    }
    const QuadraticFit fit = fitQuadratic([&](int dl, int dy, int dx) {
      const std::ptrdiff_t offset = dy * stride + dx;
      const auto l = static_cast<std::size_t>(dl + 1);
      return static_cast<double>(at[l + 1][offset] - at[l][offset]);
    });
    if (!fit.solved || !(fit.reach() < 1e6)) return false;
    if (fit.reach() < 0.5) {
      const double value = std::abs(fit.extremum()) / kUnit, trace = fit.trace(), area = fit.determinant();
      const double e = options.edge_threshold;
      if (value * options.octave_layers < options.contrast_threshold || !(area > 0) ||
          trace * trace * e >= (e + 1) * (e + 1) * area) {
        return false;
      }
      const double scale = octave.levels[0].step, start = octave.levels[0].offset;
      const double layer = level + fit.offset[2];
      keypoint.x = static_cast<float>(start + (x + fit.offset[0]) * scale);
      keypoint.y = static_cast<float>(start + (y + fit.offset[1]) * scale);
      keypoint.sigma = static_cast<float>(options.sigma * std::exp2(layer / options.octave_layers) * scale);
      keypoint.response = static_cast<float>(value);
      keypoint.layer = static_cast<float>(layer);
      keypoint.octave = extremum.octave;
      keypoint.level = static_cast<std::int16_t>(level);
      place = static_cast<std::uint64_t>(extremum.octave) << 56 | static_cast<std::uint64_t>(level) << 48 |
              static_cast<std::uint64_t>(y) << 24 | static_cast<std::uint64_t>(x);
      return true;
    }
    x += static_cast<int>(std::lround(fit.offset[0]));
    y += static_cast<int>(std::lround(fit.offset[1]));
    level += static_cast<int>(std::lround(fit.offset[2]));
    if (level < 1 || level > options.octave_layers || x < kBorder || x >= octave.width - kBorder ||
        y < kBorder || y >= octave.height - kBorder) {
      return false;
    }
  }
  return false;
}

void DogKeypoints::find(const cv::Mat& image, const DogOptions& options, const PlaceMask& mask, int threads) {
  ScaleSpaceOptions space;
  space.first_octave = options.first_octave;
  space.resolution = options.octave_layers;
  space.last_level = options.octave_layers + 2;
  space.sigma = options.sigma;
  space.smallest_side = 2 * kBorder + 1;
  Search search(options, mask);
  space_.compute(image, space, threads, &search);

  const std::vector<Extremum>& extrema = search.found();
  std::vector<DogKeypoint> refined(extrema.size());
  std::vector<std::uint64_t> places(extrema.size());
  constexpr std::uint64_t kNowhere = ~std::uint64_t{0};
  forEachBlock(extrema.size(), 256, threads, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (!refine(extrema[i], options, refined[i], places[i]) || !mask.allows({refined[i].x, refined[i].y})) {
        places[i] = kNowhere;
      }
    }
  });
  // Extrema that were moved to the same pixel are one keypoint: the first.
  std::vector<std::pair<std::uint64_t, std::size_t>> order;
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] != kNowhere) order.emplace_back(places[i], i);
  }
  std::sort(order.begin(), order.end());
  for (std::size_t i = 1; i < order.size(); ++i) {
    if (order[i].first == order[i - 1].first) places[order[i].second] = kNowhere;
  }
  keypoints_.clear();
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] != kNowhere) keypoints_.push_back(refined[i]);
  }
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
  const float least = kPeak * histogram.highest().here;
  histogram.forEachPeak([&](const Histogram::Peak& peak) {
    if (peak.here < least) return;
    const float turn = (static_cast<float>(peak.bin) + peak.offset()) / Histogram::kBins;
    angles.push_back((turn < 0 ? turn + 1 : turn >= 1 ? turn - 1 : turn) * kTwoPi);
  });
}

}  // namespace corrsel::core
