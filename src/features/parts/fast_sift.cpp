#include "features/parts/fast_sift.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <opencv2/core.hpp>

#include "features/parts/affine_patch.h"
#include "features/parts/gradient.h"
#include "features/parts/orientation_histogram.h"
#include "features/parts/quadratic_fit.h"

namespace corrsel::core {
namespace {

constexpr int kMinSide = 16;
constexpr float kTwoPi = 6.283185307F;

/// Half of a symmetric Gaussian, beginning with the middle. It is cut off at 3 sigma, and the sum of both
/// halves is 1.
std::vector<float> gaussian(double sigma) {
  const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  std::vector<double> weights;
  double sum = 0;
  for (int k = 0; k <= radius; ++k) {
    weights.push_back(std::exp(-0.5 * k * k / (sigma * sigma)));
    sum += (k == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> half;
  for (const double weight : weights) half.push_back(static_cast<float>(weight / sum));
  return half;
}

/// out[x] = half[0] * middle[x] + sum over k of half[k] * (before_k[x] + after_k[x]). It is computed in
/// blocks, so that the sums stay in registers.
template <class Before, class After>
void weightedSum(const std::vector<float>& half, const float* middle, const Before& before,
                 const After& after, int n, float* out) {
  constexpr int kBlock = 16;
  int x = 0;
  for (; x + kBlock <= n; x += kBlock) {
    float sum[kBlock];
    for (int j = 0; j < kBlock; ++j) sum[j] = half[0] * middle[x + j];
    for (std::size_t k = 1; k < half.size(); ++k) {
      const float* const a = before(k) + x;
      const float* const b = after(k) + x;
      for (int j = 0; j < kBlock; ++j) sum[j] += half[k] * (a[j] + b[j]);
    }
    for (int j = 0; j < kBlock; ++j) out[x + j] = sum[j];
  }
  for (; x < n; ++x) {
    float sum = half[0] * middle[x];
    for (std::size_t k = 1; k < half.size(); ++k) sum += half[k] * (before(k)[x] + after(k)[x]);
    out[x] = sum;
  }
}

/// Gaussian blur. Pixels outside the image equal the nearest pixel of the border.
void blur(const cv::Mat& in, double sigma, cv::Mat& out) {
  const std::vector<float> half = gaussian(sigma);
  const int radius = static_cast<int>(half.size()) - 1, width = in.cols;
  out.create(in.size(), CV_32F);
  std::vector<float> padded(static_cast<std::size_t>(width + 2 * radius));
  float* const row = padded.data() + radius;
  for (int y = 0; y < in.rows; ++y) {
    weightedSum(
        half, in.ptr<float>(y),
        [&](std::size_t k) { return in.ptr<float>(std::max(0, y - static_cast<int>(k))); },
        [&](std::size_t k) { return in.ptr<float>(std::min(in.rows - 1, y + static_cast<int>(k))); }, width,
        row);
    std::fill(padded.data(), row, row[0]);
    std::fill(row + width, row + width + radius, row[width - 1]);
    weightedSum(
        half, row, [&](std::size_t k) { return row - k; }, [&](std::size_t k) { return row + k; }, width,
        out.ptr<float>(y));
  }
}

/// Every second pixel.
cv::Mat halved(const cv::Mat& in) {
  cv::Mat out(in.rows / 2, in.cols / 2, CV_32F);
  for (int y = 0; y < out.rows; ++y) {
    const float* const from = in.ptr<float>(2 * y);
    float* const to = out.ptr<float>(y);
    for (int x = 0; x < out.cols; ++x) to[x] = from[2 * x];
  }
  return out;
}

/// Lengths and directions of the gradients of n pixels; directions in turns, from 0 to 1.
void gradients(const float* __restrict above, const float* __restrict row, const float* __restrict below,
               int n, float* __restrict length, float* __restrict turn) {
  for (int i = 0; i < n; ++i) {
    const float dx = row[i + 1] - row[i - 1], dy = below[i] - above[i];
    turn[i] = directionOf<FastArctangent>(dx, dy);
    length[i] = std::sqrt(dx * dx + dy * dy);
  }
}

/// Gaussian weights of the offsets -radius..radius from a centre at `shift` from a pixel.
void windowWeights(int radius, float shift, float sigma, std::vector<float>& weights) {
  weights.resize(static_cast<std::size_t>(2 * radius + 1));
  for (int k = -radius; k <= radius; ++k) {
    const float d = (static_cast<float>(k) - shift) / sigma;
    weights[static_cast<std::size_t>(k + radius)] = std::exp(-0.5F * d * d);
  }
}

struct Octave {
  std::vector<cv::Mat> levels, differences;
};

/// An extremum in the octave's pixels.
struct Extremum {
  float x, y, layer, response;
  int level;
};

class Sift {
 public:
  Sift(const FastSiftParameters& parameters, const AcceptKeypoint& accept)
      : p_(parameters), accept_(accept) {}

  std::vector<FastSiftFeature> run(const cv::Mat& image) {
    const auto layers = static_cast<std::size_t>(p_.octave_layers);
    octave_.levels.resize(layers + 3);
    octave_.differences.resize(layers + 2);
    if (std::min(image.rows, image.cols) < kMinSide) return {};
    blur(image, std::sqrt(std::max(0.01, p_.sigma * p_.sigma - kCameraBlur * kCameraBlur)),
         octave_.levels[0]);
    for (number_ = 0;; ++number_) {
      fill();
      findFeatures();
      const cv::Mat& next = octave_.levels[layers];
      if (std::min(next.rows, next.cols) / 2 < kMinSide) break;
      octave_.levels[0] = halved(next);
    }
    return std::move(features_);
  }

 private:
  double levelSigma(double level) const { return p_.sigma * std::exp2(level / p_.octave_layers); }

  void fill() {
    for (std::size_t i = 1; i < octave_.levels.size(); ++i) {
      const double before = levelSigma(double(i) - 1), after = levelSigma(double(i));
      blur(octave_.levels[i - 1], std::sqrt(after * after - before * before), octave_.levels[i]);
      const cv::Mat &a = octave_.levels[i - 1], &b = octave_.levels[i];
      cv::Mat& difference = octave_.differences[i - 1];
      difference.create(a.size(), CV_32F);
      for (int y = 0; y < a.rows; ++y) {
        const float *pa = a.ptr<float>(y), *pb = b.ptr<float>(y);
        float* const out = difference.ptr<float>(y);
        for (int x = 0; x < a.cols; ++x) out[x] = pb[x] - pa[x];
      }
    }
  }

  void findFeatures() {
    const double strongest = 255 * p_.contrast_threshold / p_.octave_layers;
    const auto threshold = static_cast<float>(0.5 * strongest);
    const int rows = octave_.levels[0].rows, cols = octave_.levels[0].cols;
    for (int level = 1; level <= p_.octave_layers; ++level) {
      for (int y = 1; y < rows - 1; ++y) {
        const float* const row = octave_.differences[static_cast<std::size_t>(level)].ptr<float>(y);
        for (int x = 1; x < cols - 1; ++x) {
          // The neighbours in the row are compared first, since they exclude most pixels.
          const float v = row[x];
          const bool candidate = (v > threshold && v >= row[x - 1] && v >= row[x + 1]) ||
                                 (v < -threshold && v <= row[x - 1] && v <= row[x + 1]);
          if (!candidate || !isExtremum(level, x, y)) continue;
          Extremum extremum;
          if (refine(level, x, y, strongest, extremum)) addFeatures(extremum);
        }
      }
    }
  }

  bool isExtremum(int level, int x, int y) const {
    const float v = at(level, x, y);
    for (int l = level - 1; l <= level + 1; ++l) {
      for (int dy = -1; dy <= 1; ++dy) {
        const float* const row = octave_.differences[static_cast<std::size_t>(l)].ptr<float>(y + dy) + x;
        for (int dx = -1; dx <= 1; ++dx) {
          if (v > 0 ? row[dx] > v : row[dx] < v) return false;
        }
      }
    }
    return true;
  }

  float at(int level, int x, int y) const {
    return octave_.differences[static_cast<std::size_t>(level)].at<float>(y, x);
  }

  /// Finds the extremum of the quadratic through the neighbours and rejects edges (Lowe, section 4).
  bool refine(int level, int x, int y, double strongest, Extremum& found) const {
    constexpr int kSteps = 5;
    const int rows = octave_.levels[0].rows, cols = octave_.levels[0].cols;
    for (int step = 0; step < kSteps; ++step) {
      const QuadraticFit fit =
          fitQuadratic([&](int dl, int dy, int dx) { return at(level + dl, x + dx, y + dy); });
      if (!fit.solved || !(fit.reach() < 1e3)) return false;
      if (fit.reach() < 0.5) {
        const double value = fit.extremum(), trace = fit.trace(), area = fit.determinant();
        const double e = p_.edge_threshold;
        if (std::abs(value) < strongest || !(area > 0) || trace * trace * e >= (e + 1) * (e + 1) * area) {
          return false;
        }
        found = {static_cast<float>(x + fit.offset[0]), static_cast<float>(y + fit.offset[1]),
                 static_cast<float>(level + fit.offset[2]), static_cast<float>(std::abs(value) / 255), level};
        return true;
      }
      x += static_cast<int>(std::lround(fit.offset[0]));
      y += static_cast<int>(std::lround(fit.offset[1]));
      level += static_cast<int>(std::lround(fit.offset[2]));
      if (level < 1 || level > p_.octave_layers || x < 1 || x > cols - 2 || y < 1 || y > rows - 2)
        return false;
    }
    return false;
  }

  void addFeatures(const Extremum& e) {
    const auto scale = static_cast<float>(std::ldexp(1.0, number_));
    const auto sigma = static_cast<float>(levelSigma(e.layer));
    if (!accept_(e.x * scale, e.y * scale, sigma * scale)) return;
    const cv::Mat& level = octave_.levels[static_cast<std::size_t>(e.level)];
    for (const float turn : directions(level, e, sigma)) {
      features_.push_back({e.x * scale, e.y * scale, sigma * scale, turn * kTwoPi, e.response, number_, {}});
      if (p_.describe) describe(level, e, sigma, turn, features_.back().descriptor);
    }
  }

  /// Dominant gradient directions (Lowe, section 5), in turns.
  std::vector<float> directions(const cv::Mat& level, const Extremum& e, float sigma) {
    using Histogram = OrientationHistogram<float>;
    constexpr float kPeak = 0.8F;
    const float window = 1.5F * sigma;
    const int radius = static_cast<int>(std::lround(3 * window));
    const int cx = static_cast<int>(std::lround(e.x)), cy = static_cast<int>(std::lround(e.y));
    windowWeights(radius, e.x - static_cast<float>(cx), window, across_);
    windowWeights(radius, e.y - static_cast<float>(cy), window, down_);
    const int first = std::max(1, cx - radius), last = std::min(level.cols - 2, cx + radius);
    Histogram histogram;
    for (int y = std::max(1, cy - radius); y <= std::min(level.rows - 2, cy + radius); ++y) {
      gradientRow(level, y, first, last);
      const float weight = down_[static_cast<std::size_t>(y - cy + radius)];
      const float* const across = across_.data() + (first - cx + radius);
      for (int i = 0; i <= last - first; ++i) {
        const auto k = static_cast<std::size_t>(i);
        histogram.add(static_cast<std::size_t>(static_cast<int>(turn_[k] * Histogram::kBins + 0.5F)),
                      length_[k] * weight * across[i]);
      }
    }
    histogram.smooth(1,
                     [](const auto& at) { return (at(-2) + at(2) + 4 * (at(-1) + at(1)) + 6 * at(0)) / 16; });
    const float least = kPeak * histogram.highest().here;
    std::vector<float> turns;
    histogram.forEachPeak([&](const Histogram::Peak& peak) {
      if (peak.here < least) return;
      // The order of the sum is not that of Peak::curvature(), which rounds to other angles.
      const float shift = peak.offset(peak.before - 2 * peak.here + peak.after);
      const float turn = (static_cast<float>(peak.bin) + shift) / Histogram::kBins;
      turns.push_back(turn < 0 ? turn + 1 : turn >= 1 ? turn - 1 : turn);
    });
    return turns;
  }

  void gradientRow(const cv::Mat& level, int y, int first, int last) {
    const int n = last - first + 1;
    if (n <= 0) return;
    if (length_.size() < static_cast<std::size_t>(n)) {
      length_.resize(static_cast<std::size_t>(n));
      turn_.resize(static_cast<std::size_t>(n));
    }
    gradients(level.ptr<float>(y - 1) + first, level.ptr<float>(y) + first, level.ptr<float>(y + 1) + first,
              n, length_.data(), turn_.data());
  }

  /// 4 x 4 x 8 histogram of gradients (Lowe, section 6).
  void describe(const cv::Mat& level, const Extremum& e, float sigma, float turn,
                std::array<std::uint8_t, 128>& descriptor) {
    constexpr int kSide = 4, kBins = 8;
    // An additional cell on every side and an additional direction receive the contributions that fall
    // outside.
    constexpr int kRow = (kSide + 2) * (kBins + 1), kColumn = kBins + 1;
    const float cell = 3 * sigma, reach = 0.5F * (kSide + 1);
    const float c = std::cos(turn * kTwoPi) / cell, s = std::sin(turn * kTwoPi) / cell;
    const int cx = static_cast<int>(std::lround(e.x)), cy = static_cast<int>(std::lround(e.y));
    const int radius = static_cast<int>(std::ceil(reach * cell * 1.41421356F));
    const float shift_x = e.x - static_cast<float>(cx), shift_y = e.y - static_cast<float>(cy);
    windowWeights(radius, shift_x, 0.5F * kSide * cell, across_);
    windowWeights(radius, shift_y, 0.5F * kSide * cell, down_);
    std::array<float, (kSide + 2) * kRow> histogram{};
    for (int y = std::max(1, cy - radius); y <= std::min(level.rows - 2, cy + radius); ++y) {
      const float dy = static_cast<float>(y - cy) - shift_y;
      // The part of the row inside the turned square: |c x + s dy| < reach and |c dy - s x| < reach.
      float low = static_cast<float>(-radius), high = static_cast<float>(radius);
      for (const auto& [slope, offset] : {std::pair(c, s * dy), std::pair(-s, c * dy)}) {
        if (std::abs(slope) * static_cast<float>(radius) < 1e-3F) continue;
        const float a = (-reach - offset) / slope, b = (reach - offset) / slope;
        low = std::max(low, std::min(a, b) + shift_x);
        high = std::min(high, std::max(a, b) + shift_x);
      }
      const int first = std::max(1, cx + static_cast<int>(std::ceil(low)));
      const int last = std::min(level.cols - 2, cx + static_cast<int>(std::floor(high)));
      if (first > last) continue;
      gradientRow(level, y, first, last);
      const float weight = down_[static_cast<std::size_t>(y - cy + radius)];
      const float* const across = across_.data() + (first - cx + radius);
      const float start = static_cast<float>(first - cx) - shift_x;
      for (int i = 0; i <= last - first; ++i) {
        const auto k = static_cast<std::size_t>(i);
        const float dx = start + static_cast<float>(i);
        const float u = std::clamp(c * dx + s * dy + reach, 0.0F, kSide + 0.999F);
        const float v = std::clamp(c * dy - s * dx + reach, 0.0F, kSide + 0.999F);
        float t = (turn_[k] - turn) * kBins;
        t = t < 0 ? t + kBins : t;
        const int iu = static_cast<int>(u), iv = static_cast<int>(v);
        const int it = std::min(static_cast<int>(t), kBins - 1);
        const float fu = u - static_cast<float>(iu), fv = v - static_cast<float>(iv);
        const float ft = t - static_cast<float>(it);
        const float w = length_[k] * weight * across[i];
        const float w1 = w * fv, w0 = w - w1, w11 = w1 * fu, w10 = w1 - w11, w01 = w0 * fu, w00 = w0 - w01;
        float* const h = histogram.data() + iv * kRow + iu * kColumn + it;
        h[0] += w00 - w00 * ft;
        h[1] += w00 * ft;
        h[kColumn] += w01 - w01 * ft;
        h[kColumn + 1] += w01 * ft;
        h[kRow] += w10 - w10 * ft;
        h[kRow + 1] += w10 * ft;
        h[kRow + kColumn] += w11 - w11 * ft;
        h[kRow + kColumn + 1] += w11 * ft;
      }
    }
    std::array<float, 128> values;
    std::size_t n = 0;
    float square = 0;
    for (int v = 1; v <= kSide; ++v) {
      for (int u = 1; u <= kSide; ++u) {
        float* const h = histogram.data() + v * kRow + u * kColumn;
        h[0] += h[kBins];
        for (int t = 0; t < kBins; ++t) {
          values[n++] = h[t];
          square += h[t] * h[t];
        }
      }
    }
    const float limit = 0.2F * std::sqrt(square);
    square = 0;
    for (float& value : values) {
      value = std::min(value, limit);
      square += value * value;
    }
    const float factor = 512 / std::max(std::sqrt(square), 1e-12F);
    for (std::size_t i = 0; i < values.size(); ++i)
      descriptor[i] = static_cast<std::uint8_t>(std::min(255.0F, std::round(values[i] * factor)));
  }

  const FastSiftParameters& p_;
  const AcceptKeypoint& accept_;
  Octave octave_;
  int number_ = 0;
  std::vector<FastSiftFeature> features_;
  std::vector<float> across_, down_, length_, turn_;
};

}  // namespace

std::vector<FastSiftFeature> fastSift(const cv::Mat& image, const FastSiftParameters& parameters,
                                      const AcceptKeypoint& accept) {
  return Sift(parameters, accept).run(image);
}

}  // namespace corrsel::core
