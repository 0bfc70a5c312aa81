#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>

#include "corrsel/features/features.h"

namespace corrsel::core {

/// Maps pixels of the image that a detector sees to pixels of the whole image. The detector sees an area of
/// the whole image, which may have been reduced.
class AreaTransform {
 public:
  AreaTransform() = default;

  /// @param seen  size of the image that the detector sees, px
  /// @param area  the part of the whole image that it shows, px
  AreaTransform(const cv::Size& seen, const cv::Rect& area);

  cv::Point2f operator()(const cv::Point2f& p) const {
    if (!reduced_) return {p.x + left_, p.y + top_};
    return {(p.x + 0.5F) * x_scale_ - 0.5F + left_, (p.y + 0.5F) * y_scale_ - 0.5F + top_};
  }

  /// Transforms positions, sizes and frames. The two scales differ only because sides are rounded to whole
  /// pixels, so shapes and angles are kept.
  void apply(Features& features) const;

 private:
  bool reduced_ = false;
  float left_ = 0, top_ = 0, x_scale_ = 1, y_scale_ = 1;
};

/// The places at which keypoints are allowed. Copies share the pixels.
class PlaceMask {
 public:
  /// Keypoints are allowed everywhere.
  PlaceMask() = default;

  /// Keypoints are allowed where the mask is not zero.
  /// @param mask         8-bit, one channel, not empty, in pixels of the whole image
  /// @param to_mask      from pixels of the image that the detector sees to those of the mask
  PlaceMask(const cv::Mat& mask, const AreaTransform& to_mask);

  bool everywhere() const { return mask_.empty(); }

  /// Whether a keypoint is allowed at a place of the image that the detector sees, px. The nearest pixel of
  /// the mask decides.
  bool allows(const cv::Point2f& place) const;

  /// Whether a keypoint may be allowed at some place in the given pixels of the image that the detector sees,
  /// i.e. in [x - 0.5, x + width - 0.5] x [y - 0.5, y + height - 0.5]. Never false where allows() is true for
  /// a place in it, so a detector may leave out what only concerns a rectangle for which this is false. A
  /// detector that refines positions extends the rectangle by the largest shift. True is not exact: the mask
  /// is looked up in tiles of 8 x 8 px.
  /// An empty rectangle has no places. O(1): the table of the tiles is made once, with the mask, in O(pixels
  /// of the mask).
  bool allowsAny(const cv::Rect& pixels) const;

  /// Drops the keypoints at places that are not allowed, with their frames and descriptors. O(features).
  void apply(Features& features) const;

 private:
  cv::Mat mask_;
  cv::Mat allowed_tiles_;  ///< integral image of the tiles with an allowed pixel: [row + 1][column + 1], int
  AreaTransform to_mask_;
};

}  // namespace corrsel::core
