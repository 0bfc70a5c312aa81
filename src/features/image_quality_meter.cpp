#include "corrsel/features/image_quality_meter.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "features/parts/grey_image.h"

namespace corrsel::core {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kBlack = 7, kSaturated = 255;  // grey levels of 8 bits
constexpr int kBlock = 64;                   // px
constexpr int kColumns = 8, kRows = 6;       // of blocks, at most
constexpr int kSmallest = 32;                // px, of a block
constexpr int kCell = 16;                    // px, of the estimate of noise
constexpr int kCellStep = 32;                // px
constexpr double kCalm = 0.91;      // what the calmest eighth of cells with the same noise shows of it
constexpr int kLineStep = 32;       // px
constexpr double kQuantile = 0.25;  // of the widths of edges
constexpr double kVisible = 0.5;    // px, a blur that the grid of the pixels does not hide
constexpr double kMoment = 0.25, kMemory = 5;  // s, of the sharp images
constexpr int kTextureCells = 8;               // in each direction
constexpr std::size_t kCounted = 640 * 480;    // pixels that are looked at for black and saturated

/// Counts the pixels without light and those at full scale.
class Counts {
 public:
  explicit Counts(int columns)
      : black_(static_cast<std::size_t>(columns)), saturated_(static_cast<std::size_t>(columns)) {}

  /// Counts in columns of 8 bits, a loop that compilers turn into instructions for many pixels.
  void add(const std::uint8_t* row) {
    const std::size_t columns = black_.size();
    std::uint8_t *const black = black_.data(), *const saturated = saturated_.data();
    for (std::size_t x = 0; x < columns; ++x) {
      black[x] = static_cast<std::uint8_t>(black[x] + (row[x] <= kBlack ? 1 : 0));
      saturated[x] = static_cast<std::uint8_t>(saturated[x] + (row[x] >= kSaturated ? 1 : 0));
    }
    ++rows_;
    if (++pending_ == std::numeric_limits<std::uint8_t>::max()) sum();
  }

  void shares(ImageQuality& quality) {
    sum();
    const double pixels = static_cast<double>(rows_) * static_cast<double>(black_.size());
    quality.black = static_cast<double>(n_black_) / pixels;
    quality.saturated = static_cast<double>(n_saturated_) / pixels;
  }

 private:
  static std::int64_t take(std::vector<std::uint8_t>& counts) {
    const auto sum = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
    std::fill(counts.begin(), counts.end(), std::uint8_t{0});
    return sum;
  }

  void sum() {
    n_black_ += take(black_);
    n_saturated_ += take(saturated_);
    pending_ = 0;
  }

  std::vector<std::uint8_t> black_, saturated_;
  std::int64_t n_black_ = 0, n_saturated_ = 0;
  int rows_ = 0, pending_ = 0;
};

void count(const cv::Mat& image, std::vector<std::uint8_t>& memory, ImageQuality& quality) {
  const auto every = static_cast<int>((image.total() + kCounted - 1) / kCounted);
  const bool converts = image.type() != CV_8UC1;
  if (converts) memory.resize(static_cast<std::size_t>(image.cols));
  Counts counts(image.cols);
  for (int y = std::min(every / 2, image.rows - 1); y < image.rows; y += every) {
    if (converts) {
      GreyBuffer none;
      toGrey(image.row(y), 1e6, none).copyTo(cv::Mat(1, image.cols, CV_8U, memory.data()));
    }
    counts.add(converts ? memory.data() : image.ptr(y));
  }
  counts.shares(quality);
}

/// Parts of an image in 8-bit grey, on a regular grid.
std::vector<cv::Mat> blocksOf(const cv::Mat& image, std::vector<std::uint8_t>& memory) {
  const cv::Size size(std::min(image.cols, kBlock), std::min(image.rows, kBlock));
  std::vector<cv::Mat> blocks;
  if (size.width < kSmallest || size.height < kSmallest) return blocks;
  const int columns = std::clamp(image.cols / kBlock, 1, kColumns);
  const int rows = std::clamp(image.rows / kBlock, 1, kRows);
  const bool converts = image.type() != CV_8UC1;
  if (converts) memory.resize(static_cast<std::size_t>(columns * rows) * kBlock * kBlock);
  const auto at = [](int i, int n, int free) { return n == 1 ? free / 2 : i * free / (n - 1); };
  for (int y = 0; y < rows; ++y) {
    for (int x = 0; x < columns; ++x) {
      const cv::Point corner(at(x, columns, image.cols - size.width), at(y, rows, image.rows - size.height));
      blocks.push_back(image(cv::Rect(corner, size)));
      if (!converts) continue;
      cv::Mat grey(size, CV_8U, memory.data() + (blocks.size() - 1) * kBlock * kBlock);
      GreyBuffer none;
      toGrey(blocks.back(), 1e6, none).copyTo(grey);
      blocks.back() = grey;
    }
  }
  return blocks;
}

/// Immerkaer's estimate in a cell of an image that has a pixel more on every side; NaN in a cell with pixels
/// that may be clipped.
double cellNoise(const cv::Mat& image, const cv::Point& corner) {
  int sum = 0, lowest = 255, highest = 0;
  for (int y = corner.y; y < corner.y + kCell; ++y) {
    const std::uint8_t *above = image.ptr(y - 1), *row = image.ptr(y), *below = image.ptr(y + 1);
    for (int x = corner.x; x < corner.x + kCell; ++x) {
      const int sides = row[x - 1] + row[x + 1] + above[x] + below[x];
      const int corners = above[x - 1] + above[x + 1] + below[x - 1] + below[x + 1];
      sum += std::abs(corners - 2 * sides + 4 * row[x]);
      lowest = std::min<int>(lowest, row[x]);
      highest = std::max<int>(highest, row[x]);
    }
  }
  if (lowest == 0 || highest == 255) return kNaN;
  return std::sqrt(M_PI / 2) * sum / (6.0 * kCell * kCell);
}

double noiseOf(const std::vector<cv::Mat>& blocks) {
  std::vector<double> noise;
  for (const cv::Mat& block : blocks) {
    for (int y = 8; y + kCell < block.rows; y += kCellStep) {
      for (int x = 8; x + kCell < block.cols; x += kCellStep) {
        const double value = cellNoise(block, {x, y});
        if (!std::isnan(value)) noise.push_back(value);
      }
    }
  }
  if (noise.empty()) return kNaN;
  const auto calm = noise.begin() + static_cast<std::ptrdiff_t>(noise.size() / 8);
  std::nth_element(noise.begin(), calm, noise.end());
  return *calm / kCalm;
}

/// Counts of edges by the logarithm of their width.
class Widths {
 public:
  void add(double sigma, double weight) {
    const double place = std::log(sigma / kNarrowest) * kPerUnit;
    counts_[static_cast<std::size_t>(std::clamp(place, 0.0, kBins - 1.0))] += weight;
    total_ += weight;
    ++edges_;
  }

  /// NaN where there are too few edges.
  double quantile(double q) const {
    if (edges_ < kFewest) return kNaN;
    double below = 0;
    std::size_t bin = 0;
    while (below + counts_[bin] < q * total_) below += counts_[bin++];
    const double part = counts_[bin] > 0 ? (q * total_ - below) / counts_[bin] : 0.5;
    return kNarrowest * std::exp((static_cast<double>(bin) + part) / kPerUnit);
  }

 private:
  static constexpr double kNarrowest = 0.2, kPerUnit = 20, kBins = 96;
  static constexpr int kFewest = 10;
  std::array<double, static_cast<std::size_t>(kBins)> counts_ = {};
  double total_ = 0;
  int edges_ = 0;
};

/// Pixels along a line of an image: three lines side by side.
struct Line {
  const std::uint8_t* middle;
  std::ptrdiff_t along, across;
  int length;
};

constexpr int kScale = 12;  // of smoothed samples: three lines, and 1 2 1 along them

/// Finds the edges along lines and adds their widths.
class EdgeMeter {
 public:
  /// @param noise  of a pixel
  EdgeMeter(double noise, Widths& widths) : energy_(kScale * kScale * noise * noise / 12), widths_(&widths) {
    const double sample = kScale * noise / std::sqrt(8.0);
    excess_ = 2 * sample;
    turn_ = static_cast<int>(std::max(1.0 * kScale, 3 * sample));
    least_ = static_cast<int>(std::max(8.0 * kScale, 12 * sample));
  }

  void measure(const Line& line) {
    smooth(line);
    int first = 0, last = 0, direction = 0, lowest = 0, highest = 0;
    for (int i = 1; i < length_; ++i) {
      if (direction == 0) {
        if (samples_[i] < samples_[lowest]) lowest = i;
        if (samples_[i] > samples_[highest]) highest = i;
        if (samples_[i] > samples_[lowest] + turn_) direction = 1;
        if (samples_[i] < samples_[highest] - turn_) direction = -1;
        first = direction > 0 ? lowest : highest;
        last = i;
        continue;
      }
      const int further = direction * (samples_[i] - samples_[last]);
      if (further > 0) {
        last = i;
      } else if (further < -turn_) {
        add(line, first, last);
        first = last;
        last = i;
        direction = -direction;
      }
    }
    if (direction != 0) add(line, first, last);
  }

 private:
  void smooth(const Line& line) {
    for (int i = 0; i < line.length; ++i) {
      const std::uint8_t* const pixel = line.middle + i * line.along;
      sums_[i] = pixel[-line.across] + pixel[0] + pixel[line.across];
    }
    length_ = line.length - 2;
    for (int i = 0; i < length_; ++i) samples_[i] = sums_[i] + 2 * sums_[i + 1] + sums_[i + 2];
  }

  /// An edge from one extremum to the next.
  void add(const Line& line, int first, int last) {
    const double height = std::abs(samples_[last] - samples_[first]) - excess_;
    if (height < least_) return;
    int steepest = first, peak = 0;
    double energy = 0;
    for (int i = first; i < last; ++i) {
      const int difference = std::abs(samples_[i + 1] - samples_[i]);
      energy += difference * difference;
      if (difference > peak) {
        peak = difference;
        steepest = i;
      }
    }
    // An edge that the end of the line cuts off.
    const auto slope = [this](int i) { return std::abs(samples_[i + 1] - samples_[i]); };
    if (first == 0 && 5 * slope(0) > peak) return;
    if (last == length_ - 1 && 5 * slope(last - 1) > peak) return;
    energy -= (last - first) * energy_;
    if (energy <= 0) return;
    const double cosine = cosineAt(line, steepest, peak);
    if (cosine < std::sqrt(0.5)) return;  // rather an edge of the lines in the other direction
    const double width = height * height / (2 * std::sqrt(M_PI) * energy);
    const double square = width * width * cosine * cosine - kWidening;
    widths_->add(std::sqrt(std::max(square, 0.01)), height);
  }

  /// Of the angle between the line and the gradient.
  double cosineAt(const Line& line, int sample, int peak) const {
    int across = 0;
    for (int i = sample; i < sample + 4; ++i) {
      const std::uint8_t* const pixel = line.middle + i * line.along;
      across += (i == sample || i == sample + 3 ? 1 : 3) * (pixel[line.across] - pixel[-line.across]);
    }
    // Both in units of kScale: `across` has weights of 8 over a distance of 2.
    const double gradient = kScale * across / 16.0;
    return peak / std::sqrt(1.0 * peak * peak + gradient * gradient);
  }

  /// Variance that smoothing along the line (1/2) and the difference of neighbours (1/12) add, px^2.
  static constexpr double kWidening = 0.5 + 1.0 / 12;

  const double energy_;  ///< of the noise in a difference
  Widths* const widths_;
  double excess_ = 0;  ///< by which noise raises the difference between two extrema
  int turn_ = 0;       ///< an extremum is one where the samples turn back by this much
  int least_ = 0;      ///< smallest height of an edge
  int length_ = 0;
  std::array<int, kBlock> sums_, samples_;
};

double blurOf(const std::vector<cv::Mat>& blocks, double noise) {
  double blur = kNaN;
  for (const bool horizontal : {true, false}) {
    Widths widths;
    EdgeMeter meter(noise, widths);
    for (const cv::Mat& block : blocks) {
      const auto stride = static_cast<std::ptrdiff_t>(block.step);
      const int count = horizontal ? block.rows : block.cols;
      for (int k = kLineStep / 2; k < count; k += kLineStep) {
        if (horizontal) {
          meter.measure({block.ptr(k), 1, stride, block.cols});
        } else {
          meter.measure({block.ptr(0) + k, stride, 1, block.rows});
        }
      }
    }
    const double value = widths.quantile(kQuantile);
    if (!(value <= blur)) blur = std::isnan(value) ? blur : value;
  }
  return blur;
}

}  // namespace

ImageQuality ImageQualityMeter::measure(const cv::Mat& image, double stamp) {
  checkImage(image);
  ImageQuality quality;
  count(image, grey_, quality);
  const std::vector<cv::Mat> blocks = blocksOf(image, grey_);
  quality.noise = noiseOf(blocks);
  quality.blur = blurOf(blocks, std::isnan(quality.noise) ? 0.0 : quality.noise);
  quality.relative_blur = relativeBlur(quality.blur, stamp);
  return quality;
}

double ImageQualityMeter::relativeBlur(double blur, double stamp) {
  if (!moments_.empty() && stamp < moments_.back().stamp) moments_.clear();
  if (std::isnan(blur)) return kNaN;
  const double visible = std::max(blur, kVisible);
  if (moments_.empty() || stamp >= moments_.back().stamp + kMoment) {
    moments_.push_back({stamp, visible});
  } else {
    moments_.back().blur = std::min(moments_.back().blur, visible);
  }
  while (moments_.front().stamp < stamp - kMemory) moments_.pop_front();
  std::vector<double> sharpest;
  for (const Moment& moment : moments_) sharpest.push_back(moment.blur);
  const auto quarter = sharpest.begin() + static_cast<std::ptrdiff_t>(sharpest.size() / 4);
  std::nth_element(sharpest.begin(), quarter, sharpest.end());
  return visible / *quarter;
}

double textureOf(const Features& features) {
  const cv::Size size = features.image_size;
  if (size.empty()) return kNaN;
  std::bitset<kTextureCells * kTextureCells> occupied;
  for (const cv::KeyPoint& point : features.keypoints) {
    const auto cell = [](float place, int length) {
      return std::clamp(static_cast<int>((place + 0.5F) * kTextureCells / static_cast<float>(length)), 0,
                        kTextureCells - 1);
    };
    occupied.set(static_cast<std::size_t>(cell(point.pt.y, size.height) * kTextureCells +
                                          cell(point.pt.x, size.width)));
  }
  return static_cast<double>(occupied.count()) / occupied.size();
}

}  // namespace corrsel::core
