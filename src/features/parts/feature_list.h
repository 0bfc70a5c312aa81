#pragma once

#include <opencv2/core/types.hpp>
#include <vector>

#include "corrsel/features/features.h"

namespace corrsel::core {

/// The order of features, strongest first: by falling response, then by position, size, angle, octave and
/// class. The result is therefore the same in every run, although OpenCV's threads find features in any
/// order.
bool stronger(const cv::KeyPoint& a, const cv::KeyPoint& b);

/// Replaces the features by those at the given indices, in this order. Keypoints, frames and (where present)
/// descriptors are kept together. O(features).
void reorder(const std::vector<int>& order, Features& features);

/// Keeps the features whose flag is not 0, in their order.
/// @param keep  one flag per keypoint
void keepFeatures(const std::vector<char>& keep, Features& features);

/// Sorts the features, strongest first (see stronger()), and keeps at most `max_features` of them; 0 = all. A
/// second call changes nothing, so a detector that describes its keypoints can call this before it describes
/// them. O(features log features).
/// @param spread      keep the strongest of every part of the image, see spreadOverImage()
/// @param image_size  of the image that the detector sees, px
void keepStrongest(int max_features, bool spread, const cv::Size& image_size, Features& features);

/// The similarity frame of every keypoint. Its unit disc is mapped to the circle with the keypoint's
/// diameter; the first column points along the keypoint's angle and the second column is perpendicular to it.
std::vector<AffineFrame> similarityFrames(const std::vector<cv::KeyPoint>& keypoints);

}  // namespace corrsel::core
