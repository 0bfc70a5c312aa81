#include "features/detectors/blob.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <tuple>
#include <vector>

#include "base/parallel.h"
#include "base/text.h"
#include "features/parts/affine_patch.h"
#include "features/parts/feature_list.h"
#include "features/parts/orientation_histogram.h"
#include "features/parts/quadratic_fit.h"

namespace corrsel::core {

void BlobOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.number({"threshold", 0.1, 255, "grey levels",
                  "Blob: weaker extrema are dropped; the response of a disc is 0.74 of its contrast"},
                 &BlobOptions::threshold);
  visitor.number({"min_sigma", 1, 16, "px", "Blob: smallest scale; a disc of radius r has the scale 0.71 r"},
                 &BlobOptions::min_sigma);
  visitor.number({"max_sigma", 1, 1000, "px", "Blob: largest scale"}, &BlobOptions::max_sigma);
  visitor.integer({"layers", 1, 10, "-", "Blob: scales per octave"}, &BlobOptions::layers);
  visitor.number({"edge_ratio", 1, 1000, "-",
                  "Blob: extrema with a larger ratio of principal curvatures are dropped; larger keeps more"},
                 &BlobOptions::edge_ratio);
}

void BlobOptions::check() const {
  DetectorOptions::check();
  if (min_sigma > max_sigma) {
    throw std::invalid_argument("option min_sigma = " + formatNumber(min_sigma) +
                                " is larger than max_sigma = " + formatNumber(max_sigma));
  }
}

namespace {

constexpr int kBandRows = 512;         // largest number of rows of an octave that are processed at once
constexpr int kMinSide = 8;            // of an octave, px
constexpr int kMargin = 3;             // reach of the Laplacian (2) and of the comparison (1), px
constexpr int kMaxMoves = 5;           // of the quadratic fit, to the sample nearest to the extremum
constexpr double kWindowSigmas = 1.5;  // of the window in which gradients are counted, by the blob's sigma
constexpr double kWindowReach = 3.0;   // of that window, by its own sigma
constexpr auto kBins = static_cast<int>(OrientationHistogram<float>::kBins);

/// A Gaussian blur that is cut off at 4 sigma.
struct Blur {
  double sigma;

  int radius() const { return static_cast<int>(std::ceil(4 * sigma)); }

  cv::Mat apply(const cv::Mat& image) const {
    cv::Mat blurred;
    // Isolated: a part of an image must not depend on the pixels around it.
    cv::GaussianBlur(image, blurred, {2 * radius() + 1, 2 * radius() + 1}, sigma, sigma,
                     cv::BORDER_REFLECT_101 | cv::BORDER_ISOLATED);
    return blurred;
  }
};

/// The scales of an octave. Extrema are searched on the levels 1 to layers; level `layers` is level 0 of the
/// next octave. The first two octaves have the image's own pixels, and only then is the image halved. The
/// reason is that blobs with a sigma below 3 pixels depend on the position of the pixels: only half of the
/// blobs found in an image were found in the same image rotated by 180 degrees.
struct Scales {
  Scales(const BlobOptions& options, int octave)
      : options(options), octave(octave), unit(std::exp2(std::max(octave - 1, 0))) {
    for (int level = 0; level < options.layers + 2; ++level) {
      sigma.push_back(at(level));
      const double before = level ? sigma[static_cast<std::size_t>(level - 1)] : kCameraBlur;
      blur.push_back({std::sqrt(sigma.back() * sigma.back() - before * before)});
    }
    halo = kMaxMoves + kMargin + static_cast<int>(std::ceil(kWindowSigmas * kWindowReach * sigma.back()));
    for (const Blur& step : blur) halo += step.radius();
    halo += halo % 2;
  }

  /// In the octave's pixels.
  double at(double level) const {
    return options.min_sigma * std::exp2((level - 1) / options.layers + octave) / unit;
  }

  const BlobOptions& options;
  int octave;
  double unit;                ///< a pixel of the octave, px
  std::vector<double> sigma;  ///< of each level
  std::vector<Blur> blur;  ///< from the level before; for the first level of the first octave from the image
  int halo;                ///< rows around a band on which its keypoints depend
};

/// sigma^2 times the Laplacian, second derivatives with errors of fourth order; zero at the border.
cv::Mat response(const cv::Mat& level, double sigma) {
  cv::Mat result = cv::Mat::zeros(level.size(), CV_32F);
  const auto far = static_cast<float>(-sigma * sigma / 12), near = static_cast<float>(sigma * sigma * 4 / 3);
  const auto centre = static_cast<float>(-sigma * sigma * 5);
  for (int y = 2; y < level.rows - 2; ++y) {
    const auto *up2 = level.ptr<float>(y - 2), *up = level.ptr<float>(y - 1), *row = level.ptr<float>(y);
    const auto *down = level.ptr<float>(y + 1), *down2 = level.ptr<float>(y + 2);
    auto* const out = result.ptr<float>(y);
    for (int x = 2; x < level.cols - 2; ++x) {
      out[x] = centre * row[x] + near * ((row[x - 1] + row[x + 1]) + (up[x] + down[x])) +
               far * ((row[x - 2] + row[x + 2]) + (up2[x] + down2[x]));
    }
  }
  return result;
}

/// Part of the scale space of one octave. Keypoints are searched in the rows [begin, end); the stored rows
/// begin with row `first` and include those on which the keypoints depend.
struct Band {
  int first, begin, end;
  cv::Size octave;
  std::vector<cv::Mat> levels, responses;

  float at(int level, int y, int x) const {
    return responses[static_cast<std::size_t>(level)].ptr<float>(y - first)[x];
  }
};

Band makeBand(const cv::Mat& image, int begin, int end, const Scales& scales) {
  Band band{std::max(begin - scales.halo, 0), begin, end, image.size(), {}, {}};
  cv::Mat level = image.rowRange(band.first, std::min(band.end + scales.halo, image.rows));
  if (scales.octave == 0) {
    level.convertTo(level, CV_32F);
    level = scales.blur[0].apply(level);
  }
  for (std::size_t i = 0; i < scales.sigma.size(); ++i) {
    if (i) level = scales.blur[i].apply(level);
    band.levels.push_back(level);
    band.responses.push_back(response(level, scales.sigma[i]));
  }
  return band;
}

/// Whether a sample is an extremum among its 26 neighbours: a maximum where it is positive, a minimum where
/// it is negative. Of equal samples the first one counts, so a blob halfway between two pixels is found once.
bool isExtremum(const Band& band, int level, int y, int x) {
  const float value = band.at(level, y, x), sign = value < 0 ? -1.0F : 1.0F;
  const float height = sign * value;
  for (int l = level - 1; l <= level + 1; ++l) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const float other = sign * band.at(l, y + dy, x + dx);
        const bool before = std::make_tuple(l - level, dy, dx) < std::make_tuple(0, 0, 0);
        if (other > height || (before && other == height)) return false;
      }
    }
  }
  return true;
}

/// A refined extremum, in the octave's pixels.
struct Extremum {
  int level, y, x;   ///< nearest sample
  cv::Vec3d offset;  ///< of the extremum from that sample: x, y, level
  double height;     ///< signed
};

/// Follows the quadratic fit to the extremum. Returns false where it does not converge or where the extremum
/// lies on an edge.
bool refine(const Band& band, int layers, double edge_ratio, Extremum& e) {
  for (int move = 0;; ++move) {
    const QuadraticFit fit = fitQuadratic(
        [&](int dl, int dy, int dx) -> double { return band.at(e.level + dl, e.y + dy, e.x + dx); });
    e.offset = fit.offset;
    if (!fit.solved || !(fit.reach() < kMaxMoves)) return false;
    const auto step = [&e](int axis) {
      return std::clamp(static_cast<int>(std::lround(e.offset[axis])), -1, 1);
    };
    const int level = std::clamp(e.level + step(2), 1, layers);
    const bool stays = step(0) == 0 && step(1) == 0 && level == e.level;
    // Halfway between two samples or two octaves, each of the two fits may point at the other sample.
    if (stays || move >= 2) {
      if (fit.reach() <= 1) {
        e.height = fit.extremum();
        return fit.trace() * fit.trace() * edge_ratio <=
               (edge_ratio + 1) * (edge_ratio + 1) * fit.determinant();
      }
      if (stays || move == kMaxMoves) return false;
    }
    e.x += step(0);
    e.y += step(1);
    e.level = level;
    if (e.x < kMargin || e.y < kMargin || e.x >= band.octave.width - kMargin ||
        e.y >= band.octave.height - kMargin) {
      return false;
    }
  }
}

/// The strongest peak of a histogram of gradient directions weighted by magnitude and a Gaussian window,
/// degrees in [0, 360).
float dominantAngle(const Band& band, std::size_t level, double sigma, double x, double y) {
  const cv::Mat& image = band.levels[level];
  const double window = kWindowSigmas * sigma, row = y - band.first;
  const double reach = kWindowReach * window;
  const int left = std::max(static_cast<int>(std::ceil(x - reach)), 1);
  const int right = std::min(static_cast<int>(std::floor(x + reach)), image.cols - 2);
  const int top = std::max(static_cast<int>(std::ceil(row - reach)), 1);
  const int bottom = std::min(static_cast<int>(std::floor(row + reach)), image.rows - 2);
  const auto weight = [window](double distance) {
    return static_cast<float>(std::exp(-distance * distance / (2 * window * window)));
  };
  std::vector<float> column_weight;
  for (int c = left; c <= right; ++c) column_weight.push_back(weight(c - x));
  OrientationHistogram<float> histogram;
  for (int r = top; r <= bottom; ++r) {
    const auto *up = image.ptr<float>(r - 1), *here = image.ptr<float>(r), *down = image.ptr<float>(r + 1);
    const float row_weight = weight(r - row);
    for (int c = left; c <= right; ++c) {
      const float dx = here[c + 1] - here[c - 1], dy = down[c] - up[c];
      const int bin = static_cast<int>(cv::fastAtan2(dy, dx) * (kBins / 360.0F));
      histogram.add(static_cast<std::size_t>(bin), std::sqrt(dx * dx + dy * dy) * row_weight *
                                                       column_weight[static_cast<std::size_t>(c - left)]);
    }
  }
  histogram.smooth(2, [](const auto& at) { return 0.25F * (at(-1) + at(1)) + 0.5F * at(0); });
  const auto peak = histogram.highest();
  const float shift = peak.curvature() < 0 ? peak.offset() : 0.0F;
  // A bin holds the directions from its number to the next one.
  const float angle = (static_cast<float>(peak.bin) + 0.5F + shift) * (360.0F / kBins);
  return angle >= 360.0F ? angle - 360.0F : angle;
}

/// Keypoints of a band, in the image's pixels.
std::vector<cv::KeyPoint> findKeypoints(const Band& band, const cv::Size& image, const Scales& scales) {
  const BlobOptions& options = scales.options;
  // The extremum of the fit may be stronger than the nearest sample, so the samples have a lower threshold.
  const auto candidate = static_cast<float>(0.8 * options.threshold);
  std::vector<Extremum> extrema;
  for (int level = 1; level <= options.layers; ++level) {
    const int last = std::min(band.end, band.octave.height - kMargin);
    for (int y = std::max(band.begin, kMargin); y < last; ++y) {
      const auto* const row = band.responses[static_cast<std::size_t>(level)].ptr<float>(y - band.first);
      for (int x = kMargin; x < band.octave.width - kMargin; ++x) {
        const float value = row[x];
        if (std::abs(value) < candidate) continue;
        const bool high = value >= row[x - 1] && value >= row[x + 1];
        const bool low = value <= row[x - 1] && value <= row[x + 1];
        if (!(value > 0 ? high : low) || !isExtremum(band, level, y, x)) continue;
        Extremum extremum{level, y, x, {}, 0};
        if (refine(band, options.layers, options.edge_ratio, extremum)) extrema.push_back(extremum);
      }
    }
  }

  std::vector<cv::KeyPoint> keypoints;
  const double unit = scales.unit;
  for (const Extremum& e : extrema) {
    const double level = e.level + e.offset[2], sigma = scales.at(level);
    const double x = (e.x + e.offset[0]) * unit, y = (e.y + e.offset[1]) * unit;
    const double radius = std::sqrt(2.0) * sigma * unit;
    if (std::abs(e.height) < options.threshold) continue;
    if (sigma * unit < options.min_sigma || sigma * unit > options.max_sigma) continue;
    if (x < radius || y < radius || x > image.width - 1 - radius || y > image.height - 1 - radius) continue;
    const auto nearest = static_cast<std::size_t>(std::lround(level));
    keypoints.emplace_back(static_cast<float>(x), static_cast<float>(y), static_cast<float>(2 * radius),
                           dominantAngle(band, nearest, sigma, x / unit, y / unit),
                           static_cast<float>(std::abs(e.height)), scales.octave);
  }
  return keypoints;
}

/// Removes extrema that were found from several samples or in two bands. The keypoints are then sorted by
/// rows.
void removeDuplicates(std::vector<cv::KeyPoint>& keypoints) {
  const auto place = [](const cv::KeyPoint& k) { return std::tie(k.pt.y, k.pt.x, k.size); };
  std::sort(keypoints.begin(), keypoints.end(),
            [&](const cv::KeyPoint& a, const cv::KeyPoint& b) { return place(a) < place(b); });
  keypoints.erase(
      std::unique(keypoints.begin(), keypoints.end(),
                  [&](const cv::KeyPoint& a, const cv::KeyPoint& b) { return place(a) == place(b); }),
      keypoints.end());
}

}  // namespace

BlobDetector::BlobDetector(const BlobOptions& options) : options_(options) { options_.check(); }

void BlobDetector::detect(const DetectionRequest& request, Features& features) const {
  features.keypoints.clear();
  cv::Mat image = request.image;
  for (int octave = 0; options_.min_sigma * std::exp2(octave) <= options_.max_sigma &&
                       std::min(image.cols, image.rows) >= kMinSide;
       ++octave) {
    const Scales scales(options_, octave);
    const int step = octave == 0 ? 1 : 2;  // from this octave's pixels to the next one's
    const int bands = (image.rows + kBandRows - 1) / kBandRows;
    const auto beginOf = [&](int band) {
      return band < bands ? image.rows / bands * band / 2 * 2 : image.rows;
    };
    cv::Mat next((image.rows + step - 1) / step, (image.cols + step - 1) / step, CV_32F);
    std::vector<std::vector<cv::KeyPoint>> found(static_cast<std::size_t>(bands));
    forEachBlock(found.size(), 1, request.threads, [&](std::size_t number, std::size_t) {
      const int i = static_cast<int>(number);
      const Band band = makeBand(image, beginOf(i), beginOf(i + 1), scales);
      found[number] = findKeypoints(band, request.image.size(), scales);
      const cv::Mat& base = band.levels[static_cast<std::size_t>(options_.layers)];
      for (int y = band.begin; y < band.end; y += step) {
        const auto* const from = base.ptr<float>(y - band.first);
        auto* const to = next.ptr<float>(y / step);
        for (int x = 0; x < next.cols; ++x) to[x] = from[step * x];
      }
    });
    std::vector<cv::KeyPoint> keypoints;
    for (const auto& part : found) keypoints.insert(keypoints.end(), part.begin(), part.end());
    removeDuplicates(keypoints);
    features.keypoints.insert(features.keypoints.end(), keypoints.begin(), keypoints.end());
    image = next;
  }
  features.frames = similarityFrames(features.keypoints);
  request.mask.apply(features);
}

}  // namespace corrsel::core
