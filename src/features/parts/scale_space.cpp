#include "features/parts/scale_space.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "base/parallel.h"
#include "corrsel/workspace.h"
#include "features/parts/whole_weights.h"
#include "kernels/kernels.h"

namespace corrsel::core {
namespace {

constexpr int kSlack = ScaleSpaceKernels::kRowSlack;
constexpr double kReach = 3;  // of a Gaussian, in sigmas

/// The place of the first pixel of the doubled image, px of the image: the two pixels that take the place of
/// one lie symmetrically around it.
constexpr double kDoublingOffset = -0.25;

int reachOf(double sigma) { return std::max(1, static_cast<int>(std::ceil(kReach * sigma))); }

std::ptrdiff_t padded(int width) {
  // Odd multiples of a cache line, so that the pixels of a column are in different sets of the cache.
  const std::ptrdiff_t lines = (width + 2 * kSlack - 1) / kSlack;
  return (lines | 1) * kSlack;
}

std::vector<double> gaussian(int radius, double sigma, double centre = 0) {
  std::vector<double> values;
  for (int k = -radius; k <= radius; ++k) {
    const double d = (k - centre) / sigma;
    values.push_back(std::exp(-0.5 * d * d));
  }
  return values;
}

/// A Gaussian of 2 radius + 1 samples with the variance sigma^2.
std::vector<int> gaussianWeights(double sigma) {
  const int radius = reachOf(sigma);
  const auto variance = [radius](double s) {
    double sum = 0, squares = 0;
    const std::vector<double> values = gaussian(radius, s);
    for (int k = -radius; k <= radius; ++k) {
      const double value = values[static_cast<std::size_t>(k + radius)];
      sum += value;
      squares += value * k * k;
    }
    return squares / sum;
  };
  double low = sigma / 4, high = 2 * sigma;
  for (int step = 0; step < 40; ++step) {
    const double middle = (low + high) / 2;
    (variance(middle) < sigma * sigma ? low : high) = middle;
  }
  std::vector<int> weights = wholeWeights(gaussian(radius, low));
  // No weight may be 2^15, which is not a 16-bit number.
  const auto centre = static_cast<std::size_t>(radius);
  if (weights[centre] == kWeightSum) {
    weights[centre] -= 2;
    weights[centre - 1] = weights[centre + 1] = 1;
  }
  return weights;
}

/// Mirrors positions outside at the first and the last pixel.
int mirrored(int position, int size) {
  if (size == 1) return 0;
  while (position < 0 || position >= size) {
    position = position < 0 ? -position : 2 * (size - 1) - position;
  }
  return position;
}

}  // namespace

/// How a level is computed from the level before or from the source.
struct ScaleSpace::Filter {
  int radius = 0;  ///< rows and columns on each side; 0 = a copy
  bool doubles = false;
  int pairs = 0;
  std::vector<std::int32_t> first, second;    ///< of the columns: for the first and the second row
  std::vector<std::int32_t> row, row_second;  ///< row_second only where it doubles

  static Filter blur(double sigma) {
    const std::vector<int> weights = gaussianWeights(sigma);
    Filter filter;
    filter.radius = static_cast<int>(weights.size()) / 2;
    filter.pairs = filter.radius + 1;
    filter.first = inPairs(weights, 0, filter.pairs);
    filter.second = inPairs(weights, 1, filter.pairs);
    filter.row = filter.first;
    return filter;
  }

  /// Pixels 2 i and 2 i + 1 of the doubled image show the places i - 1/4 and i + 1/4. They are interpolated
  /// linearly and then blurred.
  /// @param sigma  in pixels of the result
  static Filter doubling(double sigma) {
    const int reach = reachOf(sigma);
    const std::vector<double> blur = gaussian(reach, sigma);
    Filter filter;
    filter.doubles = true;
    filter.radius = (reach + 3) / 2;
    filter.pairs = filter.radius + 1;
    const auto phase = [&](int shown) {
      std::vector<double> weights(static_cast<std::size_t>(2 * filter.radius + 2), 0.0);
      for (int k = -reach; k <= reach; ++k) {
        const int place = shown + k;  // in the doubled image, which has two pixels for every one
        const int near = place >> 1, far = place % 2 == 0 ? near - 1 : near + 1;
        const double value = blur[static_cast<std::size_t>(k + reach)];
        weights[static_cast<std::size_t>(near + filter.radius)] += 0.75 * value;
        weights[static_cast<std::size_t>(far + filter.radius)] += 0.25 * value;
      }
      return inPairs(wholeWeights(weights), 0, filter.pairs);
    };
    filter.first = filter.row = phase(0);
    filter.second = filter.row_second = phase(1);
    return filter;
  }
};

/// What the bands of one octave have in common.
struct ScaleSpace::Plan {
  const ScaleOctave* octave;
  std::vector<Filter> filters;  ///< one per level
  cv::Size source_size;         ///< of the pixels of which level 0 is made
  cv::Mat image;                ///< CV_8U or CV_16S; or empty: the level `before` of the octave before
  const ScaleLevel* before = nullptr;
  int source_step = 1;  ///< pixels of the image or level between two pixels of the source

  int halo() const {
    int rows = 1;
    for (const Filter& filter : filters) rows += filter.doubles ? 2 * filter.radius : filter.radius;
    return rows;
  }

  void sourceRow(int y, std::int16_t* out) const {
    if (image.empty()) {
      const std::int16_t* const in = before->pixels + std::ptrdiff_t{y} * source_step * before->stride;
      for (int x = 0; x < source_size.width; ++x) out[x] = in[std::ptrdiff_t{x} * source_step];
    } else if (image.type() == CV_8U) {
      const std::uint8_t* const in = image.ptr<std::uint8_t>(y * source_step);
      if (source_step == 1) {
        for (int x = 0; x < source_size.width; ++x) out[x] = static_cast<std::int16_t>(in[x] * kGreyUnit);
      } else {
        for (int x = 0; x < source_size.width; ++x) {
          out[x] = static_cast<std::int16_t>(in[std::ptrdiff_t{x} * source_step] * kGreyUnit);
        }
      }
    } else {
      const std::int16_t* const in = image.ptr<std::int16_t>(y * source_step);
      for (int x = 0; x < source_size.width; ++x) out[x] = in[std::ptrdiff_t{x} * source_step];
    }
  }
};

/// One thread's rows of an octave. Rows of a level are computed when the next level needs them.
class ScaleSpace::Band {
 public:
  /// Kept for the next image.
  struct Memory {
    std::vector<std::int16_t> rows, line;
    std::vector<const std::int16_t*> filtered;
    ScaleRows tables;
    std::vector<std::int16_t*> source;
  };

  Band(const Plan& plan, int number, int begin, int end, Workspace& workspace)
      : plan_(plan), memory_(workspace.part<Memory>()), begin_(begin), end_(end) {
    memory_.tables.band_ = number;
    const std::size_t own = chooseRows();
    // The source's rows are kept as long as a filter needs them.
    const Filter& start = plan.filters[0];
    int kept = 1;
    while (kept < 2 * start.radius + 4) kept *= 2;
    source_mask_ = kept - 1;
    source_stride_ = padded(plan.source_size.width);
    const int from = start.doubles ? done_[0] / 2 : done_[0];
    source_done_ = std::max(0, from - start.radius);
    placeRows(own, static_cast<std::size_t>(kept));
    int reach = start.radius;
    for (const Filter& filter : plan.filters) reach = std::max(reach, filter.radius);
    const int widest = std::max(plan.source_size.width, plan.octave->width);
    line_stride_ = static_cast<std::size_t>(widest + 2 * reach + 2 + 3 * kSlack);
    if (memory_.line.size() < 2 * line_stride_) memory_.line.resize(2 * line_stride_);
  }

  void run(ScaleRowVisitor* visitor) {
    const std::size_t top = plan_.octave->levels.size() - 1;
    for (int y = begin_; y < end_; ++y) {
      produce(top, std::min(last_[top], y + 2));
      if (visitor != nullptr) visitor->visit(*plan_.octave, memory_.tables, y);
    }
  }

 private:
  static std::int16_t* aligned(std::int16_t* p) {
    const auto address = reinterpret_cast<std::uintptr_t>(p);
    return p + (address % 64 == 0 ? 0 : (64 - address % 64) / sizeof(std::int16_t));
  }

  /// Sets the rows of every level: those of the band, one more on each side, and those that the next level
  /// needs.
  /// @return number of rows outside of the band
  std::size_t chooseRows() {
    const int height = plan_.octave->height;
    const std::size_t levels = plan_.octave->levels.size();
    ScaleRows& tables = memory_.tables;
    tables.tables_.resize(levels);
    tables.first_rows_.resize(levels);
    last_.resize(levels);
    done_.resize(levels);
    int first = std::max(0, begin_ - 1), last = std::min(height, end_ + 1);
    std::size_t own = 0;
    for (std::size_t l = levels; l-- > 0;) {
      if (plan_.filters[l].doubles) {
        first &= ~1;
        last = std::min(height, (last + 1) & ~1);
      }
      tables.first_rows_[l] = done_[l] = first;
      last_[l] = last;
      own += static_cast<std::size_t>(begin_ - first + last - end_);
      const int radius = plan_.filters[l].radius;
      first = std::max(0, first - radius);
      last = std::min(height, last + radius);
    }
    return own;
  }

  /// Sets the pointers to all rows. Those of the band are rows of the octave, the others lie in the memory.
  /// @param own   number of rows outside of the band
  /// @param kept  number of rows of the source
  void placeRows(std::size_t own, std::size_t kept) {
    const auto stride = static_cast<std::size_t>(plan_.octave->levels[0].stride);
    const std::size_t total =
        (own + 1) * stride + kept * static_cast<std::size_t>(source_stride_) + std::size_t{kSlack};
    if (memory_.rows.size() < total) {
      memory_.rows.clear();
      memory_.rows.resize(total);
    }
    std::int16_t* next = aligned(memory_.rows.data());
    unused_ = next;
    next += stride;
    ScaleRows& tables = memory_.tables;
    for (std::size_t l = 0; l < plan_.octave->levels.size(); ++l) {
      const ScaleLevel& level = plan_.octave->levels[l];
      std::vector<std::int16_t*>& table = tables.tables_[l];
      table.clear();
      for (int y = tables.first_rows_[l]; y < last_[l]; ++y) {
        if (y >= begin_ && y < end_) {
          table.push_back(const_cast<std::int16_t*>(level.pixels) + std::ptrdiff_t{y} * level.stride);
        } else {
          table.push_back(next);
          next += stride;
        }
      }
    }
    source_ring_ = next;
  }

  std::int16_t* rowOf(std::size_t level, int y) const {
    return memory_.tables.tables_[level][static_cast<std::size_t>(y - memory_.tables.first_rows_[level])];
  }

  std::int16_t* sourceRow(int y) const { return source_ring_ + (y & source_mask_) * source_stride_; }

  void produceSource(int until) {
    for (; source_done_ < until; ++source_done_) plan_.sourceRow(source_done_, sourceRow(source_done_));
  }

  /// Computes the rows of a level before `until`.
  void produce(std::size_t level, int until) {
    const Filter& filter = plan_.filters[level];
    const int height = level == 0 ? plan_.source_size.height : plan_.octave->height;
    int& done = done_[level];
    while (done < until) {
      if (filter.radius == 0) {
        plan_.sourceRow(done, rowOf(0, done));
        ++done;
        continue;
      }
      const int centre = filter.doubles ? done / 2 : done;
      const int end = centre + filter.radius + 2;
      std::vector<const std::int16_t*>& rows = memory_.filtered;
      if (level == 0) {
        produceSource(std::min(height, end));
      } else {
        produce(level - 1, std::min(last_[level - 1], end));
      }
      rows.clear();
      // The last row has no weight where it is beyond the computed ones.
      const int last = level == 0 ? height - 1 : last_[level - 1] - 1;
      for (int y = centre - filter.radius; y < end; ++y) {
        const int inside = std::min(mirrored(y, height), last);
        rows.push_back(level == 0 ? sourceRow(inside) : rowOf(level - 1, inside));
      }
      const int width = level == 0 ? plan_.source_size.width : plan_.octave->width;
      std::int16_t* const first = memory_.line.data() + filter.radius;
      std::int16_t* const second = first + line_stride_;
      const ScaleSpaceKernels& kernel = kernels().scale_space;
      kernel.filterColumns(rows.data(), filter.first.data(), filter.second.data(), filter.pairs, width, first,
                           second);
      filterRow(filter, first, width, rowOf(level, done));
      filterRow(filter, second, width, done + 1 < last_[level] ? rowOf(level, done + 1) : unused_);
      done += 2;
    }
  }

  void filterRow(const Filter& filter, std::int16_t* line, int width, std::int16_t* out) const {
    for (int k = 1; k <= filter.radius + 1; ++k) {
      line[width - 1 + k] = line[mirrored(width - 1 + k, width)];
    }
    for (int k = 1; k <= filter.radius; ++k) line[-k] = line[mirrored(-k, width)];
    const ScaleSpaceKernels& kernel = kernels().scale_space;
    if (filter.doubles) {
      kernel.doubleRow(line - filter.radius, filter.row.data(), filter.row_second.data(), filter.pairs, width,
                       out);
    } else {
      kernel.filterRow(line - filter.radius, filter.row.data(), filter.pairs, width, out);
    }
  }

  const Plan& plan_;
  Memory& memory_;
  int begin_, end_;
  std::vector<int> last_, done_;
  std::int16_t *unused_, *source_ring_;
  std::ptrdiff_t source_stride_;
  int source_mask_, source_done_;
  std::size_t line_stride_;
};

void ScaleSpace::allocate(const cv::Size& image, const ScaleSpaceOptions& options) {
  octaves_.clear();
  std::size_t total = kSlack;
  for (int number = options.first_octave;; ++number) {
    ScaleOctave octave;
    octave.number = number;
    octave.width = number < 0 ? image.width << -number : image.width >> number;
    octave.height = number < 0 ? image.height << -number : image.height >> number;
    if (std::min(octave.width, octave.height) < std::max(1, options.min_side)) break;
    for (int k = options.first_level; k <= options.last_level; ++k) {
      ScaleLevel level;
      level.stride = padded(octave.width);
      level.width = octave.width;
      level.height = octave.height;
      level.step = std::ldexp(1.0, number);
      level.offset = options.first_octave < 0 ? kDoublingOffset : 0;
      level.sigma = level.step * options.sigma * std::exp2(double{1} * k / options.resolution);
      octave.levels.push_back(level);
      total += static_cast<std::size_t>(level.stride) * static_cast<std::size_t>(level.height);
    }
    octaves_.push_back(octave);
  }
  // Memory for a much larger image is given back.
  if (pixels_.size() < total || pixels_.size() / 8 > total) {
    pixels_ = {};
    pixels_.resize(total);
  }
  std::int16_t* next = pixels_.data();
  while (reinterpret_cast<std::uintptr_t>(next) % 64 != 0) ++next;
  for (ScaleOctave& octave : octaves_) {
    for (ScaleLevel& level : octave.levels) {
      level.pixels = next;
      next += level.stride * level.height;
    }
  }
}

void ScaleSpace::compute(const cv::Mat& image, const ScaleSpaceOptions& options, int threads,
                         ScaleRowVisitor* visitor) {
  allocate(image.size(), options);
  const auto levelSigma = [&options](int k) {
    return options.sigma * std::exp2(double{1} * k / options.resolution);
  };
  // What brings a blur to a larger one, in pixels of an octave.
  const auto missing = [](double present, double wanted) {
    return std::sqrt(std::max(0.01, wanted * wanted - present * present));
  };
  Plan plan;
  plan.filters.resize(static_cast<std::size_t>(options.last_level - options.first_level) + 1);
  for (int k = options.first_level + 1; k <= options.last_level; ++k) {
    plan.filters[static_cast<std::size_t>(k - options.first_level)] =
        Filter::blur(missing(levelSigma(k - 1), levelSigma(k)));
  }
  const int source_level = std::min(options.first_level + options.resolution, options.last_level);
  for (std::size_t i = 0; i < octaves_.size(); ++i) {
    const ScaleOctave& octave = octaves_[i];
    plan.octave = &octave;
    const double start = levelSigma(options.first_level);
    if (i > 0) {
      plan.image = cv::Mat();
      plan.before = &octaves_[i - 1].levels[static_cast<std::size_t>(source_level - options.first_level)];
      plan.source_size = {octave.width, octave.height};
      plan.source_step = 2;
      plan.filters[0] = source_level - options.first_level == options.resolution
                            ? Filter()
                            : Filter::blur(missing(levelSigma(source_level) / 2, start));
    } else if (octave.number < 0) {
      plan.image = image;
      plan.source_size = image.size();
      plan.filters[0] = Filter::doubling(missing(kCameraBlur * 2, start));
    } else {
      plan.image = image;
      plan.source_step = 1 << octave.number;
      plan.source_size = {octave.width, octave.height};
      plan.filters[0] = Filter::blur(missing(kCameraBlur / plan.source_step, start));
    }
    // In smaller bands, the repeated rows and the start of a thread would cost what the thread saves.
    const int bands = std::clamp(octave.height / std::max(32, 4 * plan.halo()), 1, std::max(1, threads));
    if (visitor != nullptr) visitor->begin(octave, bands);
    forEachBlock(static_cast<std::size_t>(bands), 1, threads, [&](std::size_t band, std::size_t) {
      const auto row = [&](std::size_t number) {
        return static_cast<int>(static_cast<std::int64_t>(octave.height) * static_cast<std::int64_t>(number) /
                                bands);
      };
      Band(plan, static_cast<int>(band), row(band), row(band + 1), Workspace::ofThread()).run(visitor);
    });
  }
}

std::vector<ScaleLevel> ScaleSpace::levels() const {
  std::vector<ScaleLevel> levels;
  for (const ScaleOctave& octave : octaves_) {
    levels.insert(levels.end(), octave.levels.begin(), octave.levels.end());
  }
  return levels;
}

}  // namespace corrsel::core
