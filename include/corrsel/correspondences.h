#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/types.hpp>
#include <optional>
#include <string>
#include <vector>

#include "corrsel/camera.h"
#include "corrsel/motion_guess.h"
#include "corrsel/pose_prior.h"

namespace corrsel::core {

/// Local affine frame, row-major 2x3: [a11 a12 x; a21 a22 y] maps the unit disc to the feature's ellipse, px.
using AffineFrame = std::array<float, 6>;

/// Putative matches between two images, as a structure of arrays. Row i of every column belongs to match i.
/// Optional columns are either empty or as long as the coordinates.
struct Correspondences {
  std::vector<float> left_x, left_y;  ///< position in the left image, px, origin at the first pixel's centre
  std::vector<float> right_x, right_y;  ///< position in the right image, px

  std::vector<float> distance;  ///< optional: descriptor distance to the nearest neighbour, its metric's unit
  std::vector<float>
      second_distance;  ///< optional: distance to the second-nearest neighbour; NaN if there is none
  std::vector<float>
      probability;  ///< optional: that the match is right, by the matcher, 0 to 1; NaN = unknown
  std::vector<AffineFrame> left_frame, right_frame;    ///< optional: local affine frames, px
  std::vector<std::uint32_t> left_index, right_index;  ///< optional: feature numbers in their images

  cv::Size left_size, right_size;                   ///< image sizes, px; 0x0 if unknown
  std::optional<Camera> left_camera, right_camera;  ///< optional: calibration, used by calibrated selectors
  std::optional<PosePrior> prior;    ///< optional: what is known of the motion, used by the selector `pose`
  std::optional<MotionGuess> guess;  ///< optional: what is believed of the motion, tested by `pose`

  std::size_t size() const { return left_x.size(); }
  bool empty() const { return left_x.empty(); }

  /// Appends a match that has coordinates only. @pre no optional column is in use
  void add(const cv::Point2f& left, const cv::Point2f& right);

  /// Returns an empty text if all columns have the same length, every probability is from 0 to 1 or NaN, and
  /// the cameras, the prior and the guess are valid; otherwise a sentence that names the wrong column, with
  /// the row and the value of a wrong probability, or the wrong member of a camera, of the prior or of the
  /// guess. O(matches).
  std::string inconsistency() const;

  /// Returns the given rows, in that order, with every column, and the sizes, the cameras, the prior and the
  /// guess. O(rows).
  Correspondences subset(const std::vector<std::uint32_t>& rows) const;
};

/// Row numbers where the mask is not zero.
std::vector<std::uint32_t> selectedRows(const std::vector<std::uint8_t>& mask);

}  // namespace corrsel::core
