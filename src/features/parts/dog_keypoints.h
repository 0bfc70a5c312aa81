#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "features/parts/place_mask.h"
#include "features/parts/scale_space.h"

namespace corrsel::core {

struct DogOptions {
  int first_octave = -1;             ///< -1 begins with the doubled image, 0 with the image
  int octave_layers = 3;             ///< levels per octave in which keypoints are searched
  double contrast_threshold = 0.04;  ///< smallest contrast, grey levels / 255; divided by octave_layers
  double edge_threshold = 10;        ///< largest ratio of the principal curvatures
  double sigma = 1.6;                ///< blur of the first level of an octave, pixels of the octave
};

struct DogKeypoint {
  float x, y;           ///< px of the image
  float sigma;          ///< scale, px of the image
  float response;       ///< contrast, grey levels / 255
  float layer;          ///< refined level within the octave; scales grow by 2^(1 / octave_layers) per level
  std::int16_t octave;  ///< index in ScaleSpace::octaves()
  std::int16_t level;   ///< index in ScaleOctave::levels of the level from which it is described
};

/// Asks for the pixels of a level within `reach` of a place, both in px of the image, so that they come from
/// memory while another keypoint is processed. Keypoints are far apart in memory, and waiting for their
/// pixels would take longer than processing them.
void prefetch(const ScaleLevel& level, double x, double y, double reach);

/// Keypoints where differences of Gaussians are extremal over space and scale.
///
/// Algorithm: Levels of ScaleSpace are subtracted while they are computed. Values above half of the contrast
/// threshold that are the largest or smallest of their 27 neighbours are moved to the extremum of the
/// quadratic through these neighbours, in at most five steps. Points of low contrast, and those where the
/// ratio of the principal curvatures exceeds the edge threshold, are dropped. The constants are those of
/// OpenCV's SIFT, including the border of five pixels of the octave.
///
/// Cost: That of the scale space, and a fraction of a microsecond for every extremum. The memory is kept for
/// the next image.
///
/// Source: Lowe, "Distinctive Image Features from Scale-Invariant Keypoints", IJCV 2004, sections 3 to 5.
class DogKeypoints {
 public:
  /// @param image  as for ScaleSpace::compute()
  /// @param mask   keypoints at other places are not found, and where it allows none no extrema are searched
  /// @param threads  that may be used; the result does not depend on it
  void find(const cv::Mat& image, const DogOptions& options, const PlaceMask& mask, int threads);

  /// In a fixed order.
  const std::vector<DogKeypoint>& keypoints() const { return keypoints_; }

  /// The scale space of the image. Rows have 32 pixels behind the last one.
  const ScaleSpace& space() const { return space_; }

  const ScaleLevel& levelOf(const DogKeypoint& keypoint) const {
    return space_.octaves()[static_cast<std::size_t>(keypoint.octave)]
        .levels[static_cast<std::size_t>(keypoint.level)];
  }

  /// How far directions() looks, px of the image.
  static double reachOfDirections(const DogKeypoint& keypoint) { return 4.5 * keypoint.sigma; }

  /// The dominant directions of the gradients around a keypoint, radians in [0, 2 pi), clockwise in the
  /// image, in ascending order (Lowe, section 5). Usually one or two.
  void directions(const DogKeypoint& keypoint, std::vector<float>& angles) const;

 private:
  class Search;

  ScaleSpace space_;
  std::vector<DogKeypoint> keypoints_;
};

}  // namespace corrsel::core
