#pragma once

#include <cstddef>
#include <cstdint>
#include <opencv2/core/matx.hpp>
#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/features/features.h"
#include "corrsel/motion_guess.h"
#include "matching/nearest.h"
#include "points/cell_grid.h"
#include "points/point_cells.h"

namespace corrsel::core {

/// Where the right features of left ones are by a guess of the motion: all right features within a reach of
/// the place of infinite depth or, where the translation is known, of the epipolar curve from this place to
/// the epipole. Lengths are in px of the right image; those along the rows of a panorama are multiplied by
/// the cosine of the latitude, and its rows are closed.
class PredictedAreas {
 public:
  /// @pre cameras and guess are valid, and they live as long as this object, as do the features
  PredictedAreas(const Features& left, const Features& right, const Camera& left_camera,
                 const Camera& right_camera, const MotionGuess& guess, int threads);

  /// Treats the translation as unknown.
  void forgetTranslation() { translation_.reset(); }
  bool knowsTranslation() const { return translation_.has_value(); }

  double unit() const { return unit_; }    ///< that of lengths in the right image, px
  double sigma() const { return sigma_; }  ///< standard deviation of a place in the middle of the image, px

  /// Whether the place of infinite depth is in the right image.
  bool isInside(std::uint32_t left) const;

  /// Distances of right features from the place or the curve of a left one, px; infinite where it has none.
  /// @param reach  up to which they are exact
  void distances(std::uint32_t left, double reach, const std::vector<std::uint32_t>& rights,
                 std::vector<double>& result) const;

  /// All left features whose place is in the right image or near it, in groups of those that are near to each
  /// other, and the right features that are in the area of one of a group, or as near to their mean.
  std::vector<CandidateGroup> groups(double reach, int threads) const;

 private:
  using Path = std::vector<cv::Point2d>;
  struct Segment;

  void indexRight(const Features& right);
  void predict(const Features& left, const Camera& left_camera, const MotionGuess& guess, int threads);
  Path pathOf(const cv::Point2d& place, const cv::Vec3d& direction, double reach) const;
  void mark(const Segment& segment, double reach, std::vector<std::uint64_t>& bits) const;
  Segment segmentOf(const Path& path, std::size_t k) const;
  void findTrains(double reach, CandidateGroup& group) const;
  double rowScale(double y) const;

  const Camera& camera_;  ///< the right one
  std::optional<cv::Vec3d> translation_;
  cv::Size2d size_;  ///< of the right image, px
  double unit_ = 1, sigma_ = 0, pixel_angle_ = 1;
  bool closed_ = false;  ///< whether the rows of the right image are
  std::vector<float> right_x_, right_y_;
  PointCells cells_;
  std::vector<std::uint32_t> at_slot_;  ///< the right feature in a slot of the cells
  std::vector<float> slot_x_, slot_y_;  ///< and its place
  std::vector<cv::Vec3d> directions_;   ///< of the left features, in the right camera
  std::vector<cv::Point2d> places_;     ///< of infinite depth, px; NaN where there is none
};

}  // namespace corrsel::core
