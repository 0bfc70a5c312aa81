#include "features/detectors/hessian_affine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "base/parallel.h"
#include "features/parts/affine_patch.h"
#include "features/parts/orientation_histogram.h"
#include "features/parts/scale_space.h"
#include "kernels/kernels.h"
#include "points/cell_grid.h"

namespace corrsel::core {
namespace {

/// The smallest side of an octave, px.
constexpr int kMinSide = 15;

/// The blur before the first level of an octave, pixels of the octave.
constexpr double kBaseBlur = 1.6;

/// Kept for the next image.
struct HessianScaleSpace {
  ScaleSpace space;
};

/// A feature that is being computed.
struct Candidate {
  AffineFrame frame;
  float strength;     ///< |determinant of the Hessian|
  std::size_t order;  ///< of its extremum: by level, row and column

  static bool isStronger(const Candidate& a, const Candidate& b) {
    return a.strength > b.strength || (a.strength == b.strength && a.order < b.order);
  }

  /// The order in which neighbours come together, so that their pixels are still in the cache.
  static bool isEarlier(const Candidate& a, const Candidate& b) { return a.order < b.order; }
};

/// The extrema of the determinant of the Hessian in the levels of a scale space.
class HessianExtrema {
 public:
  HessianExtrema(const std::vector<ScaleLevel>& levels, const HessianAffineOptions& options)
      : levels_(levels), options_(options) {}

  /// In the order of levels, rows and columns.
  std::vector<Candidate> find(int threads) const {
    std::vector<Rows> blocks;
    for (const ScaleLevel& level : levels_) {
      for (int y = kBorder; y < level.height - kBorder; y += kBlockRows) {
        blocks.push_back({&level, y, std::min(y + kBlockRows, level.height - kBorder)});
      }
    }
    std::vector<std::vector<Candidate>> found(blocks.size());
    forEachBlock(blocks.size(), 1, threads,
                 [&](std::size_t begin, std::size_t) { search(blocks[begin], found[begin]); });
    std::vector<Candidate> all;
    for (const std::vector<Candidate>& some : found) all.insert(all.end(), some.begin(), some.end());
    for (std::size_t i = 0; i < all.size(); ++i) all[i].order = i;
    return all;
  }

 private:
  static constexpr int kBlockRows = 64;
  static constexpr int kBorder = 2;        // pixels without a response, or without one on each side
  static constexpr float kWeakest = 0.8F;  // of the threshold, before the extremum is refined

  /// Rows of a level.
  struct Rows {
    const ScaleLevel* level;
    int begin, end;
  };

  /// For the determinant of grey values from 0 to 1, normalised to the scale.
  static float factorOf(const ScaleLevel& level) {
    const double unit = square(level.sigma / level.step) / (255.0 * kGreyUnit);
    return static_cast<float>(square(unit));
  }

  static double square(double x) { return x * x; }

  void search(const Rows& rows, std::vector<Candidate>& found) const {
    const ScaleLevel& level = *rows.level;
    const auto width = static_cast<std::size_t>(level.width);
    const auto threshold = kWeakest * static_cast<float>(options_.peak_threshold);
    const float factor = factorOf(level);
    std::vector<float> responses(3 * width);
    std::vector<std::int32_t> columns(width);
    const auto responsesOf = [&](int y) {
      return responses.data() + static_cast<std::size_t>(y % 3) * width;
    };
    const auto respond = [&](int y) {
      const std::int16_t* const row = level.pixels + y * level.stride;
      kernels().hessian.responses(row - level.stride, row, row + level.stride, level.width, factor,
                                  responsesOf(y));
    };
    respond(rows.begin - 1);
    respond(rows.begin);
    for (int y = rows.begin; y < rows.end; ++y) {
      respond(y + 1);
      const float* const three[3] = {responsesOf(y - 1), responsesOf(y), responsesOf(y + 1)};
      const int n =
          kernels().hessian.extrema(three, kBorder, level.width - kBorder, threshold, columns.data());
      for (int i = 0; i < n; ++i) refine(level, columns[static_cast<std::size_t>(i)], y, factor, found);
    }
  }

  /// Moves an extremum to that of the quadratic through its neighbours, and adds it unless it is too weak or
  /// on an edge of the response.
  void refine(const ScaleLevel& level, int x, int y, float factor, std::vector<Candidate>& found) const {
    constexpr int kSteps = 5;
    constexpr double kOtherPixel = 0.6, kFarthest = 1.5;
    double dx = 0, dy = 0, value = 0, edge = 0;
    for (int step = 0; step < kSteps; ++step) {
      const Neighbours at(level, x, y, factor);
      const double gx = 0.5 * (at(1, 0) - at(-1, 0)), gy = 0.5 * (at(0, 1) - at(0, -1));
      const double xx = at(1, 0) + at(-1, 0) - 2 * at(0, 0), yy = at(0, 1) + at(0, -1) - 2 * at(0, 0);
      const double xy = 0.25 * (at(1, 1) + at(-1, -1) - at(-1, 1) - at(1, -1));
      const double determinant = xx * yy - xy * xy;
      // The ratio of the principal curvatures; infinite where they differ in sign.
      const double ratio = square(xx + yy) / determinant;
      edge = ratio >= 0 ? 0.5 * ratio - 1 + std::sqrt(std::max(0.0, 0.25 * ratio - 1) * ratio)
                        : std::numeric_limits<double>::infinity();
      dx = determinant != 0 ? (xy * gy - yy * gx) / determinant : 0;
      dy = determinant != 0 ? (xy * gx - xx * gy) / determinant : 0;
      value = at(0, 0) + 0.5 * (gx * dx + gy * dy);
      const int to_x = std::clamp(x + (dx > kOtherPixel    ? 1
                                       : dx < -kOtherPixel ? -1
                                                           : 0),
                                  kBorder, level.width - 1 - kBorder);
      const int to_y = std::clamp(y + (dy > kOtherPixel    ? 1
                                       : dy < -kOtherPixel ? -1
                                                           : 0),
                                  kBorder, level.height - 1 - kBorder);
      if (to_x == x && to_y == y) break;
      x = to_x;
      y = to_y;
    }
    if (!(std::abs(dx) < kFarthest && std::abs(dy) < kFarthest && std::abs(value) > options_.peak_threshold &&
          edge < options_.edge_threshold)) {
      return;
    }
    const auto place = [&level](double px) { return static_cast<float>(level.offset + px * level.step); };
    const auto sigma = static_cast<float>(level.sigma);
    found.push_back(
        {{sigma, 0, place(x + dx), 0, sigma, place(y + dy)}, static_cast<float>(std::abs(value)), 0});
  }

  /// The responses at a pixel and around it.
  class Neighbours {
   public:
    Neighbours(const ScaleLevel& level, int x, int y, float factor) {
      // Five pixels from the left, of which three have a response.
      float row[5];
      for (int k = 0; k < 3; ++k) {
        const std::int16_t* const p = level.pixels + (y - 1 + k) * level.stride + x - 2;
        kernels().hessian.responses(p - level.stride, p, p + level.stride, 5, factor, row);
        std::copy_n(row + 1, 3, values_ + std::ptrdiff_t{3} * k);
      }
    }
    double operator()(int dx, int dy) const { return double{values_[3 * (dy + 1) + dx + 1]}; }

   private:
    float values_[9];
  };

  const std::vector<ScaleLevel>& levels_;
  const HessianAffineOptions& options_;
};

/// Laplacians of Gaussians over one octave around the scale of a frame, applied to a patch of it.
class ScaleSelection {
 public:
  static constexpr std::size_t kMaxScales = 4;

  ScaleSelection() {
    for (int k = 0; k < kLevels; ++k) {
      // The blur that the patch lacks, in samples.
      const double sigma = std::sqrt(square(scaleAt(k)) - square(kBlur)) / kSpacing;
      const auto gaussian = [sigma](int x) {
        if (sigma < 1e-6) return x == 0 ? 1.0 : 0.0;
        return std::exp(-0.5 * square(x / sigma));
      };
      double sum = 0;
      for (int x = -kReach; x <= kReach; ++x) sum += gaussian(x);
      const auto g = [&](int x) { return std::abs(x) > kReach ? 0.0 : gaussian(x) / sum; };
      const auto curvature = [&](int x) { return g(x - 1) - 2 * g(x) + g(x + 1); };
      for (int y = 0; y <= Patch::kHalf; ++y) {
        for (int x = -Patch::kHalf; x <= Patch::kHalf; ++x) {
          filters_.values[k][y][x + Patch::kHalf] =
              static_cast<float>((curvature(x) * g(y) + g(x) * curvature(y)) / 255);
        }
      }
    }
  }

  /// Extrema of the scale-normalised Laplacian of grey values from 0 to 1, as factors of the frame's scale.
  /// @param frame  of equal half axes along x and y
  std::vector<double> operator()(const std::vector<ScaleLevel>& levels, const AffineFrame& frame,
                                 double threshold) const {
    const auto unit = double{frame[0]};
    const ScaleLevel& level = levelFor(levels, kBlur * unit);
    std::array<float, kLevels> sums;
    filterPatch(level, frame, kSpacing, filters_, sums.data());
    // The finest level may be more blurred than requested. The scales are therefore those of its actual blur.
    const double excess = square(level.sigma / unit) - square(kBlur);
    const auto realScale = [excess](double k) { return std::sqrt(square(scaleAt(k)) + excess); };
    std::array<double, kLevels> response;
    for (int k = 0; k < kLevels; ++k) {
      response[static_cast<std::size_t>(k)] =
          double{sums[static_cast<std::size_t>(k)]} * (square(scaleAt(k)) + excess);
    }
    std::vector<double> scales;
    for (std::size_t k = 1; k + 1 < kLevels && scales.size() < kMaxScales; ++k) {
      const double a = response[k - 1], b = response[k], c = response[k + 1];
      if (((b > a && b > c) || (b < a && b < c)) && std::abs(b) >= threshold) {
        scales.push_back(realScale(static_cast<double>(k) - 0.5 * (c - a) / (c + a - 2 * b)));
      }
    }
    return scales;
  }

 private:
  static constexpr int kLevels = PatchFilters::kCount;
  static constexpr double kBlur = 0.70710678118654752, kSpacing = kBlur / 2;
  static constexpr int kReach = 24;  // of the filters' Gaussian, samples

  static double square(double x) { return x * x; }
  static double scaleAt(double k) { return std::exp2(-0.5 + k / (kLevels - 1)); }

  PatchFilters filters_ = {};
};

/// Computes shape and directions of frames, one after the other. It keeps a patch, so each thread needs its
/// own.
class FrameEstimator {
 public:
  explicit FrameEstimator(const std::vector<ScaleLevel>& levels) : levels_(levels) {}

  /// The frame whose second moment matrix is a multiple of the identity, with orthogonal axes.
  AffineFrame adapted(const AffineFrame& start) {
    const double reference = start[0];
    // Sigma = A A': the shape without a direction.
    double xx = 1, xy = 0, yy = 1;
    AffineFrame frame = start;
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      // Eigenvectors and values: the frame is U D, with the smaller half axis at the reference.
      const double angle = 0.5 * std::atan2(2 * xy, xx - yy);
      const double mean = (xx + yy) / 2, spread = std::hypot((xx - yy) / 2, xy);
      const double anisotropy = std::sqrt((mean + spread) / (mean - spread));
      if (!(anisotropy <= kMaxAnisotropy)) return frame;
      const double major = reference * anisotropy, minor = reference;
      const double c = std::cos(angle), s = std::sin(angle);
      frame[0] = static_cast<float>(c * major);
      frame[1] = static_cast<float>(-s * minor);
      frame[3] = static_cast<float>(s * major);
      frame[4] = static_cast<float>(c * minor);
      sample(frame);
      const GradientMoments moments = kernels().patches.moments(patch_, window());
      const double mxx = double{moments.xx}, mxy = double{moments.xy}, myy = double{moments.yy};
      const double determinant = mxx * myy - mxy * mxy;
      if (!(mxx > 0 && myy > 0 && determinant > 0)) return start;
      const double m_mean = (mxx + myy) / 2, m_spread = std::hypot((mxx - myy) / 2, mxy);
      if (m_mean + m_spread < kConverged * (m_mean - m_spread)) return frame;
      // Sigma <- A M^-1 A', with A = U D.
      const double p = major * major * myy / determinant, q = -major * minor * mxy / determinant,
                   r = minor * minor * mxx / determinant;
      xx = c * c * p - 2 * c * s * q + s * s * r;
      xy = c * s * (p - r) + (c * c - s * s) * q;
      yy = s * s * p + 2 * c * s * q + c * c * r;
    }
    return frame;
  }

  /// Directions of the strongest gradients in a frame with orthogonal axes, strongest first, rad.
  std::vector<double> directions(const AffineFrame& frame) {
    if (frame != sampled_) sample(frame);
    // The blur that the patch lacks, which differs between its axes.
    const double along = std::hypot(frame[0], frame[3]), across = std::hypot(frame[1], frame[4]);
    smooth(missingBlur(level_->sigma / along), missingBlur(level_->sigma / across));
    kernels().patches.directions(patch_, window(), counts_);

    Histogram histogram;
    for (std::size_t k = 0; k < kBins; ++k) histogram.add(k, double{counts_.bins[k]});
    histogram.smooth(6, [](const auto& at) { return (at(-1) + at(0) + at(1)) / 3; });
    const double min_height = 0.8 * histogram.highest().here;
    std::vector<std::pair<double, double>> peaks;
    histogram.forEachPeak([&](const Histogram::Peak& peak) {
      if (!(peak.here > min_height)) return;
      peaks.emplace_back(-peak.here, 2 * CV_PI * (static_cast<double>(peak.bin) + peak.offset()) / kBins);
    });
    std::sort(peaks.begin(), peaks.end());
    std::vector<double> angles;
    angles.reserve(peaks.size());
    for (const auto& peak : peaks) angles.push_back(peak.second);
    return angles;
  }

 private:
  using Histogram = OrientationHistogram<double>;

  static constexpr double kWindow = 3;     // sigma of the weights, in units of the frame
  static constexpr double kSpacing = 0.5;  // of the samples
  static constexpr int kMaxIterations = 15;
  static constexpr double kMaxAnisotropy = 5, kConverged = 1.05;
  static constexpr std::size_t kBins = Histogram::kBins;

  static const PatchWeights& window() {
    static const PatchWeights weights = gaussianWindow(kWindow / kSpacing);
    return weights;
  }

  static double missingBlur(double present) {
    return present < 1 ? std::sqrt(1 - present * present) / kSpacing : 0;
  }

  void sample(const AffineFrame& frame) {
    level_ = &levelFor(levels_, halfAxes(frame).smaller);
    samplePatch(*level_, frame, kSpacing, patch_);
    sampled_ = frame;
  }

  /// Blurs patch_ along rows and columns, sigmas in samples.
  void smooth(double sigma_x, double sigma_y) {
    sampled_ = {};
    if (sigma_x > 0) {
      const int reach = setFilter(sigma_x);
      kernels().patches.blur_rows(filter_.data(), reach, patch_);
    }
    if (sigma_y > 0) {
      const int reach = setFilter(sigma_y);
      kernels().patches.blur_columns(filter_.data(), reach, patch_);
    }
  }

  /// Half of a Gaussian of sum 1 in filter_, from the middle; returns its reach.
  int setFilter(double sigma) {
    const int reach = std::min(PatchKernels::kMaxReach, static_cast<int>(std::ceil(3 * sigma)));
    double sum = -1;
    for (int t = 0; t <= reach; ++t) sum += 2 * std::exp(-t * t / (2 * sigma * sigma));
    for (int t = 0; t <= reach; ++t) {
      filter_[static_cast<std::size_t>(t)] = static_cast<float>(std::exp(-t * t / (2 * sigma * sigma)) / sum);
    }
    return reach;
  }

  const std::vector<ScaleLevel>& levels_;
  AffineFrame sampled_{};              // the frame that patch_ shows; zeros where there is none
  const ScaleLevel* level_ = nullptr;  // the level from which patch_ was sampled
  Patch patch_;
  DirectionCounts counts_;
  std::array<float, PatchKernels::kMaxReach + 1> filter_;
};

/// Drops candidates close to a stronger one of nearly the same scale. Candidates are given in the order of
/// falling strength.
class OverlapFilter {
 public:
  OverlapFilter(const cv::Size& size, float overlap)
      : overlap_(overlap),
        grid_(CellGrid::covering(0, 0, size.width, size.height, kCell)),
        newest_(grid_.cells(), -1) {}

  /// Whether the candidate is kept.
  bool keeps(const AffineFrame& frame) {
    const float x = frame[2], y = frame[5], reach = overlap_ * (1 + overlap_) * frame[0];
    for (int r = grid_.row(y - reach); r <= grid_.row(y + reach); ++r) {
      for (int c = grid_.column(x - reach); c <= grid_.column(x + reach); ++c) {
        for (int i = newest_[grid_.number(c, r)]; i >= 0; i = kept_[static_cast<std::size_t>(i)].next) {
          if (covers(kept_[static_cast<std::size_t>(i)], frame)) return false;
        }
      }
    }
    int& newest = newest_[grid_.cell(x, y)];
    kept_.push_back({x, y, frame[0], newest});
    newest = static_cast<int>(kept_.size()) - 1;
    return true;
  }

 private:
  static constexpr double kCell = 8;  // px

  struct Kept {
    float x, y, sigma;
    int next;  // one that was kept before, in the same cell; -1 = none
  };

  bool covers(const Kept& other, const AffineFrame& frame) const {
    return other.sigma < (1 + overlap_) * frame[0] && frame[0] < (1 + overlap_) * other.sigma &&
           std::abs(other.x - frame[2]) < overlap_ * other.sigma &&
           std::abs(other.y - frame[5]) < overlap_ * other.sigma;
  }

  float overlap_;
  CellGrid grid_;
  std::vector<int> newest_;  // in each cell; -1 = none
  std::vector<Kept> kept_;
};

/// Whether the square of `margin` units of the frame on each side of its centre lies inside the image.
bool insideImage(const AffineFrame& frame, double margin, const cv::Size& size) {
  const double reach_x = margin * (std::abs(frame[0]) + std::abs(frame[1]));
  const double reach_y = margin * (std::abs(frame[3]) + std::abs(frame[4]));
  return frame[2] - reach_x >= 0 && frame[2] + reach_x <= size.width - 1 && frame[5] - reach_y >= 0 &&
         frame[5] + reach_y <= size.height - 1;
}

AffineFrame turned(const AffineFrame& frame, double angle) {
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  return {frame[0] * c + frame[1] * s, frame[1] * c - frame[0] * s, frame[2],
          frame[3] * c + frame[4] * s, frame[4] * c - frame[3] * s, frame[5]};
}

cv::KeyPoint keypointOf(const AffineFrame& frame, float strength) {
  const double area = double{frame[0]} * frame[4] - double{frame[1]} * frame[3];
  double angle = std::atan2(frame[3], frame[0]) * 180 / CV_PI;
  if (angle < 0) angle += 360;
  return {frame[2], frame[5], static_cast<float>(2 * std::sqrt(area)), static_cast<float>(angle), strength};
}

/// Processes n items in blocks, in parallel, and concatenates the results in the order of the blocks.
template <class T, class Item>
std::vector<T> inOrder(std::size_t n, int threads, const Item& items) {
  constexpr std::size_t kBlock = 64;
  std::vector<std::vector<T>> blocks((n + kBlock - 1) / kBlock);
  forEachBlock(n, kBlock, threads,
               [&](std::size_t begin, std::size_t end) { items(begin, end, blocks[begin / kBlock]); });
  std::vector<T> all;
  for (const std::vector<T>& block : blocks) all.insert(all.end(), block.begin(), block.end());
  return all;
}

/// Candidates at the scales that suit them, from extrema in the order of places.
std::vector<Candidate> scaledCandidates(const HessianAffineOptions& options,
                                        const std::vector<ScaleLevel>& levels, const Candidate* extrema,
                                        std::size_t n, int threads) {
  static const ScaleSelection scale_selection;
  return inOrder<Candidate>(
      n, threads, [&](std::size_t begin, std::size_t end, std::vector<Candidate>& results) {
        for (std::size_t i = begin; i < end; ++i) {
          const auto& [frame, strength, order] = extrema[i];
          for (const double scale : scale_selection(levels, frame, options.scale_threshold)) {
            const auto sigma = static_cast<float>(scale * frame[0]);
            results.push_back({{sigma, 0, frame[2], 0, sigma, frame[5]}, strength, order});
          }
        }
      });
}

/// Candidates with their affine shapes and directions, as far as their frames lie inside the image.
std::vector<Candidate> orientedCandidates(const HessianAffineOptions& options,
                                          const std::vector<ScaleLevel>& levels,
                                          const std::vector<Candidate>& candidates, const cv::Size& image,
                                          int threads) {
  return inOrder<Candidate>(
      candidates.size(), threads, [&](std::size_t begin, std::size_t end, std::vector<Candidate>& results) {
        FrameEstimator estimator(levels);
        for (std::size_t i = begin; i < end; ++i) {
          const auto& [start, strength, order] = candidates[i];
          const AffineFrame frame = options.adapt ? estimator.adapted(start) : start;
          std::vector<double> directions = estimator.directions(frame);
          directions.resize(std::min(directions.size(), static_cast<std::size_t>(options.max_orientations)));
          for (const double direction : directions) {
            const AffineFrame result = turned(frame, direction);
            if (insideImage(result, options.margin, image)) results.push_back({result, strength, order});
          }
        }
      });
}

}  // namespace

void HessianAffineOptions::visit(OptionVisitor& visitor) const {
  visitCommon(visitor);
  visitor.number({"peak_threshold", 0, 1, "-", "Smallest determinant of the Hessian, of grey values 0 to 1"},
                 &HessianAffineOptions::peak_threshold);
  visitor.number(
      {"edge_threshold", 1, 100, "-", "Largest ratio of the principal curvatures; larger keeps more"},
      &HessianAffineOptions::edge_threshold);
  visitor.number(
      {"scale_threshold", 0, 1, "-", "Smallest Laplacian at the chosen scale, of grey values 0 to 1"},
      &HessianAffineOptions::scale_threshold);
  visitor.integer(
      {"first_octave", -1, 3, "-", "-1 doubles the image: smaller features, 2 to 4 times the time"},
      &HessianAffineOptions::first_octave);
  visitor.integer({"octave_resolution", 2, 10, "-", "Levels per octave"},
                  &HessianAffineOptions::octave_resolution);
  visitor.flag("adapt", "Adapt frames to the affine shape; otherwise they are similarities",
               &HessianAffineOptions::adapt);
  visitor.integer({"max_orientations", 1, 4, "-", "Features with one position and shape"},
                  &HessianAffineOptions::max_orientations);
  visitor.number({"overlap", 0, 1, "scale", "Drops features nearer than this to a stronger one; 0 = none"},
                 &HessianAffineOptions::overlap);
  visitor.number({"margin", 0, 20, "scale", "Part of the frame that must be inside the image"},
                 &HessianAffineOptions::margin);
}

HessianAffineDetector::HessianAffineDetector(const HessianAffineOptions& options) : options_(options) {
  options_.check();
}

void HessianAffineDetector::detect(const DetectionRequest& request, Features& features) const {
  const cv::Mat& grey = request.image;
  const int threads = request.threads;
  features.keypoints.clear();
  features.frames.clear();
  if (std::min(grey.cols, grey.rows) <= kMinSide << std::max(0, options_.first_octave)) return;
  ScaleSpaceOptions space_options;
  space_options.first_octave = options_.first_octave;
  space_options.resolution = options_.octave_resolution;
  space_options.last_level = options_.octave_resolution - 1;
  space_options.sigma = kBaseBlur * std::exp2(1.0 / options_.octave_resolution);
  space_options.min_side = kMinSide;
  auto& space = request.workspace.part<HessianScaleSpace>().space;
  space.compute(grey, space_options, threads);
  const std::vector<ScaleLevel> levels = space.levels();
  if (request.levels != nullptr) *request.levels = levels;

  const auto overlap = static_cast<float>(options_.overlap);
  std::vector<Candidate> found = HessianExtrema(levels, options_).find(threads);
  std::sort(found.begin(), found.end(), Candidate::isStronger);
  // Strong candidates are processed first. Weaker ones have no influence on them, so the rest is left out
  // once there are enough features.
  const std::size_t max_features = options_.spread ? 0 : static_cast<std::size_t>(options_.max_features);
  const std::size_t batch = max_features == 0 ? found.size() : std::max<std::size_t>(max_features, 256);
  OverlapFilter overlaps(grey.size(), overlap);
  std::vector<Candidate> all;
  for (std::size_t first = 0; first < found.size(); first += batch) {
    if (max_features > 0 && all.size() >= max_features &&
        found[first].strength < all[max_features - 1].strength)
      break;
    Candidate* const extrema = found.data() + first;
    const std::size_t n = std::min(batch, found.size() - first);
    std::sort(extrema, extrema + n, Candidate::isEarlier);
    std::vector<Candidate> candidates = scaledCandidates(options_, levels, extrema, n, threads);
    std::stable_sort(candidates.begin(), candidates.end(), Candidate::isStronger);
    // Neither shape nor direction moves a feature, so those of masked features need not be found.
    const auto dropped = [&](const Candidate& candidate) {
      return !overlaps.keeps(candidate.frame) ||
             !request.mask.allows({candidate.frame[2], candidate.frame[5]});
    };
    candidates.erase(std::remove_if(candidates.begin(), candidates.end(), dropped), candidates.end());
    std::stable_sort(candidates.begin(), candidates.end(), Candidate::isEarlier);
    std::vector<Candidate> results = orientedCandidates(options_, levels, candidates, grey.size(), threads);
    std::stable_sort(results.begin(), results.end(), Candidate::isStronger);
    all.insert(all.end(), results.begin(), results.end());
  }
  for (const Candidate& candidate : all) {
    features.keypoints.push_back(keypointOf(candidate.frame, candidate.strength));
    features.frames.push_back(candidate.frame);
  }
}

}  // namespace corrsel::core
