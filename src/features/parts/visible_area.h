#pragma once

#include <opencv2/core/types.hpp>

#include "corrsel/features/region.h"

namespace corrsel::core {

/// The part of the area of a region that is inside an image of this size, px; the whole image for an empty
/// area. O(1). Throws std::invalid_argument that names the value for an area outside the image, and for a
/// mask of another type or size.
cv::Rect visibleArea(const FeatureRegion& region, const cv::Size& image);

}  // namespace corrsel::core
