#include "features/detectors/hessian_affine.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <new>
#include <numeric>
#include <opencv2/core.hpp>
#include <vector>

#include "base/parallel.h"
#include "features/parts/affine_patch.h"
#include "features/parts/orientation_histogram.h"
#include "kernels/kernels.h"

extern "C" {
#include <vl/covdet.h>
}

namespace corrsel::core {
namespace {

/// A feature that is being computed: frame, and strength = |determinant of the Hessian|.
struct Candidate {
  AffineFrame frame;
  float strength;
};

/// VLFeat's detector, which computes the scale space and the extrema of the Hessian. The steps for each
/// feature are implemented in this file, because VLFeat would need a scale space for every thread, compares
/// all features with all others, and takes four times as long.
class HessianExtrema {
 public:
  HessianExtrema(const cv::Mat& grey, const HessianAffineOptions& options)
      : covdet_(vl_covdet_new(VL_COVDET_METHOD_MULTISCALE_HESSIAN)) {
    if (!covdet_) throw std::bad_alloc();
    vl_covdet_set_first_octave(covdet_.get(), options.first_octave);
    vl_covdet_set_octave_resolution(covdet_.get(), static_cast<vl_size>(options.octave_resolution));
    vl_covdet_set_peak_threshold(covdet_.get(), options.peak_threshold);
    vl_covdet_set_edge_threshold(covdet_.get(), options.edge_threshold);
    vl_covdet_set_non_extrema_suppression_threshold(covdet_.get(), 0);
    {
      cv::Mat image;
      grey.convertTo(image, CV_32F, 1 / 255.0);
      if (vl_covdet_put_image(covdet_.get(), image.ptr<float>(), static_cast<vl_size>(image.cols),
                              static_cast<vl_size>(image.rows)) != VL_ERR_OK) {
        throw std::bad_alloc();
      }
    }
    vl_covdet_detect(covdet_.get());
  }

  std::vector<Candidate> candidates() const {
    const auto* const features = static_cast<const VlCovDetFeature*>(vl_covdet_get_features(covdet_.get()));
    std::vector<Candidate> candidates(vl_covdet_get_num_features(covdet_.get()));
    for (std::size_t i = 0; i < candidates.size(); ++i) {
      const VlFrameOrientedEllipse& f = features[i].frame;
      candidates[i] = {{f.a11, f.a12, f.x, f.a21, f.a22, f.y}, std::abs(features[i].peakScore)};
    }
    return candidates;
  }

  /// Valid as long as this object.
  std::vector<ScaleLevel> levels() {
    const VlScaleSpace* const space = vl_covdet_get_gss(covdet_.get());
    const VlScaleSpaceGeometry geometry = vl_scalespace_get_geometry(space);
    std::vector<ScaleLevel> levels;
    for (vl_index o = geometry.firstOctave; o <= geometry.lastOctave; ++o) {
      const VlScaleSpaceOctaveGeometry octave = vl_scalespace_get_octave_geometry(space, o);
      for (vl_index s = geometry.octaveFirstSubdivision; s <= geometry.octaveLastSubdivision; ++s) {
        // VLFeat's interface is not const; the pixels are only read.
        const cv::Mat level(static_cast<int>(octave.height), static_cast<int>(octave.width), CV_32F,
                            const_cast<float*>(vl_scalespace_get_level_const(space, o, s)));
        cv::Mat numbers;
        level.convertTo(numbers, CV_16S, 255 * kGreyUnit);
        levels_.push_back(numbers);
        levels.push_back({numbers.ptr<std::int16_t>(), static_cast<std::ptrdiff_t>(numbers.step1()),
                          level.cols, level.rows, octave.step, vl_scalespace_get_level_sigma(space, o, s)});
      }
    }
    return levels;
  }

 private:
  struct Deleter {
    void operator()(VlCovDet* covdet) const { vl_covdet_delete(covdet); }
  };
  std::unique_ptr<VlCovDet, Deleter> covdet_;
  std::vector<cv::Mat> levels_;  // as whole numbers
};

/// Laplacians of Gaussians over one octave around the scale of a frame, applied to a patch of it.
class ScaleSelection {
 public:
  static constexpr int kHalf = Patch::kHalf, kLevels = 10;
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
      for (int y = -kHalf; y <= kHalf; ++y) {
        auto at =
            static_cast<std::size_t>((y + kHalf) * Patch::kPitch) * kPadded + static_cast<std::size_t>(k);
        for (int x = -kHalf; x <= kHalf; ++x) {
          filters_[at] = static_cast<float>(curvature(x) * g(y) + g(x) * curvature(y));
          at += kPadded;
        }
      }
    }
  }

  /// Extrema of the scale-normalised Laplacian, as factors of the frame's scale.
  std::vector<double> operator()(const std::vector<ScaleLevel>& levels, const AffineFrame& frame,
                                 double threshold) const {
    const double unit = halfAxes(frame).smaller;
    const ScaleLevel& level = levelFor(levels, kBlur * unit);
    Patch patch;
    samplePatch(level, frame, kSpacing, patch);
    std::array<float, kPadded> sums{};
    for (std::size_t q = 0; q < kCount; ++q) {
      for (std::size_t k = 0; k < kPadded; ++k) sums[k] += filters_[q * kPadded + k] * patch.values[q];
    }
    // The finest level may be more blurred than requested. The scales are therefore those of its actual blur.
    const double excess = square(level.sigma / unit) - square(kBlur);
    const auto realScale = [excess](double k) { return std::sqrt(square(scaleAt(k)) + excess); };
    std::array<double, kLevels> response;
    for (int k = 0; k < kLevels; ++k) {
      response[static_cast<std::size_t>(k)] =
          double{sums[static_cast<std::size_t>(k)]} / 255 * square(realScale(k));
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
  static constexpr double kBlur = 0.70710678118654752, kSpacing = kBlur / 2;
  static constexpr int kReach = 24;           // of the filters' Gaussian, samples
  static constexpr std::size_t kPadded = 12;  // filters side by side, for whole vectors
  static constexpr std::size_t kCount = std::size_t{Patch::kSide} * Patch::kPitch;

  static double square(double x) { return x * x; }
  static double scaleAt(double k) { return std::exp2(-0.5 + k / (kLevels - 1)); }

  std::array<float, kCount * kPadded> filters_{};
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
      const GradientMoments moments = kernels().patches.moments(patch_, window_);
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
    kernels().patches.directions(patch_, window_, counts_);

    Histogram histogram;
    for (std::size_t k = 0; k < kBins; ++k) histogram.add(k, double{counts_.bins[k]});
    histogram.smooth(6, [](const auto& at) { return (at(-1) + at(0) + at(1)) / 3; });
    const double least = 0.8 * histogram.highest().here;
    std::vector<std::pair<double, double>> peaks;
    histogram.forEachPeak([&](const Histogram::Peak& peak) {
      if (!(peak.here > least)) return;
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
    const int reach = std::min(PatchKernels::kMostReach, static_cast<int>(std::ceil(3 * sigma)));
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
  PatchWeights window_ = gaussianWindow(kWindow / kSpacing);
  DirectionCounts counts_;
  std::array<float, PatchKernels::kMostReach + 1> filter_;
};

/// A grid of positions, which finds those near a place.
class Grid {
 public:
  explicit Grid(const cv::Size& size)
      : columns_(size.width / kCell + 1),
        rows_(size.height / kCell + 1),
        cells_(std::size_t(columns_) * rows_) {}

  void add(float x, float y, std::size_t index) { cells_[cellOf(column(x), row(y))].push_back(index); }

  /// Whether `test` is true for a position within `reach`. Positions farther away may be tested too.
  template <class Test>
  bool any(float x, float y, float reach, const Test& test) const {
    for (int r = row(y - reach); r <= row(y + reach); ++r) {
      for (int c = column(x - reach); c <= column(x + reach); ++c) {
        for (const std::size_t index : cells_[cellOf(c, r)]) {
          if (test(index)) return true;
        }
      }
    }
    return false;
  }

 private:
  static constexpr int kCell = 8;  // px

  int column(float x) const { return std::clamp(static_cast<int>(x) / kCell, 0, columns_ - 1); }
  int row(float y) const { return std::clamp(static_cast<int>(y) / kCell, 0, rows_ - 1); }
  std::size_t cellOf(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
           static_cast<std::size_t>(column);
  }

  int columns_, rows_;
  std::vector<std::vector<std::size_t>> cells_;
};

/// Drops candidates close to a stronger one of nearly the same scale.
std::vector<Candidate> withoutOverlaps(std::vector<Candidate> candidates, float overlap,
                                       const cv::Size& size) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.strength > b.strength; });
  Grid grid(size);
  std::vector<Candidate> kept;
  for (const Candidate& candidate : candidates) {
    const float x = candidate.frame[2], y = candidate.frame[5], sigma = candidate.frame[0];
    const bool covered = grid.any(x, y, overlap * (1 + overlap) * sigma, [&](std::size_t index) {
      const AffineFrame& other = kept[index].frame;
      return other[0] < (1 + overlap) * sigma && sigma < (1 + overlap) * other[0] &&
             std::abs(other[2] - x) < overlap * other[0] && std::abs(other[5] - y) < overlap * other[0];
    });
    if (covered) continue;
    grid.add(x, y, kept.size());
    kept.push_back(candidate);
  }
  return kept;
}

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
  visitor.integer({"first_octave", -1, 3, "-", "-1 doubles the image: smaller features, 4 times the time"},
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
  // In smaller images VLFeat has no octave.
  if (std::min(grey.cols, grey.rows) < 15 * (1 << std::max(0, options_.first_octave)) + 1) return;
  HessianExtrema extrema(grey, options_);
  const std::vector<ScaleLevel> levels = extrema.levels();

  static const ScaleSelection scale_selection;
  const std::vector<Candidate> found = extrema.candidates();
  std::vector<Candidate> candidates = inOrder<Candidate>(
      found.size(), threads, [&](std::size_t begin, std::size_t end, std::vector<Candidate>& scaled) {
        for (std::size_t i = begin; i < end; ++i) {
          for (const double scale : scale_selection(levels, found[i].frame, options_.scale_threshold)) {
            const auto sigma = static_cast<float>(scale * found[i].frame[0]);
            scaled.push_back({{sigma, 0, found[i].frame[2], 0, sigma, found[i].frame[5]}, found[i].strength});
          }
        }
      });
  candidates = withoutOverlaps(std::move(candidates), static_cast<float>(options_.overlap), grey.size());
  // Neither shape nor direction moves a feature, so those of masked features need not be found.
  const auto masked = [&request](const Candidate& candidate) {
    return !request.mask.allows({candidate.frame[2], candidate.frame[5]});
  };
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(), masked), candidates.end());

  candidates = inOrder<Candidate>(
      candidates.size(), threads, [&](std::size_t begin, std::size_t end, std::vector<Candidate>& oriented) {
        FrameEstimator estimator(levels);
        for (std::size_t i = begin; i < end; ++i) {
          const AffineFrame& start = candidates[i].frame;
          const AffineFrame frame = options_.adapt ? estimator.adapted(start) : start;
          std::vector<double> directions = estimator.directions(frame);
          directions.resize(std::min(directions.size(), static_cast<std::size_t>(options_.max_orientations)));
          for (const double direction : directions) {
            const AffineFrame result = turned(frame, direction);
            if (insideImage(result, options_.margin, grey.size())) {
              oriented.push_back({result, candidates[i].strength});
            }
          }
        }
      });
  for (const Candidate& candidate : candidates) {
    features.keypoints.push_back(keypointOf(candidate.frame, candidate.strength));
    features.frames.push_back(candidate.frame);
  }
}

}  // namespace corrsel::core
