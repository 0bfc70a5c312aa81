#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "features/parts/scale_level.h"

namespace corrsel::core {

struct ScaleSpaceOptions {
  int first_octave =
      -1;               ///< -1 begins with the doubled image, 0 with the image, k > 0 with every 2^k-th pixel
  int resolution = 3;   ///< levels after which the blur has doubled, at least 1
  int first_level = 0;  ///< of every octave; may be negative
  int last_level = 5;   ///< of every octave, inclusive
  double sigma = 1.6;   ///< total blur of level 0 of an octave, in pixels of the octave
  int min_side = 12;    ///< octaves whose width or height is below this are left out, px of the octave
};

/// One octave of a scale space: levels with the same distance between pixels.
struct ScaleOctave {
  int number = 0;  ///< its step is 2^number
  int width = 0, height = 0;
  std::vector<ScaleLevel> levels;  ///< first_level to last_level
};

/// The rows of all levels of one octave that one thread has computed.
class ScaleRows {
 public:
  /// @param level  index in ScaleOctave::levels
  /// @param y      row, at most one row above or below the one that is visited
  const std::int16_t* operator()(std::size_t level, int y) const {
    return tables_[level][static_cast<std::size_t>(y - first_rows_[level])];
  }

  int band() const { return band_; }

 private:
  friend class ScaleSpace;
  int band_ = 0;
  std::vector<std::vector<std::int16_t*>> tables_;  ///< [level][y - first row]
  std::vector<int> first_rows_;
};

/// Sees the rows of a scale space as soon as they are computed, while they are in the cache.
class ScaleRowVisitor {
 public:
  virtual ~ScaleRowVisitor() = default;

  /// Called before the rows of an octave are visited. The octave is divided into bands of rows, from top to
  /// bottom. Bands may be visited at the same time; the rows of one band are visited in ascending order.
  virtual void begin(const ScaleOctave& octave, int bands) = 0;

  /// Called once for every row.
  virtual void visit(const ScaleOctave& octave, const ScaleRows& rows, int y) = 0;
};

/// Gaussian scale space in 16 bits.
///
/// Idea: A pixel is a whole number, so blurring needs half the memory of floating point, vectors hold twice
/// as many pixels, and the result does not depend on the order of operations.
///
/// Algorithm: A pixel is kGreyUnit times its grey level. The level k of an octave has a blur of sigma *
/// 2^(k / resolution) pixels of the octave. It is computed from the level before by a Gaussian that is cut
/// off at about 3 sigma and whose variance is exact. Pixels outside the image mirror those inside. The first
/// level of an octave is every second pixel of a level of the octave before. With first_octave = -1,
/// doubling by linear interpolation and the first blur are one filter. The doubled image is sampled as
/// OpenCV's SIFT samples it, a quarter of a pixel on each side of a pixel. All levels of an octave are
/// computed row by row, so that the rows that are needed are still in the cache. Every thread computes a band
/// of rows and repeats the rows at its borders, so the result does not depend on the number of threads.
///
/// Cost: 2 bytes for every pixel of every level, which are kept for the next image. Time is proportional to
/// the pixels times the sum of the blurs.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004, section 3.
class ScaleSpace {
 public:
  /// @param image    CV_8U grey levels, or CV_16S from 0 to 255 * kGreyUnit; not empty
  /// @param threads  that may be used; the result does not depend on it
  /// @param visitor  null where none is needed
  void compute(const cv::Mat& image, const ScaleSpaceOptions& options, int threads,
               ScaleRowVisitor* visitor = nullptr);

  /// In ascending order of the step; none where the image is too small. Valid until the next compute().
  const std::vector<ScaleOctave>& octaves() const { return octaves_; }

  /// The levels of all octaves, one octave after the other.
  std::vector<ScaleLevel> levels() const;

 private:
  struct Filter;
  struct Plan;
  class Band;

  void allocate(const cv::Size& image, const ScaleSpaceOptions& options);

  std::vector<ScaleOctave> octaves_;
  std::vector<std::int16_t> pixels_;
};

}  // namespace corrsel::core
