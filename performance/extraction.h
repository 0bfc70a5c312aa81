#pragma once

#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "measurement.h"

namespace corrsel::performance {

/// Bytes of one feature in the outcome of the methods below.
inline constexpr std::size_t kFeatureBytes = 24;

/// Detection and description of the left photograph of a size by an extractor. The outcome, in place of a
/// mask, has kFeatureBytes for every feature, which differ where its place, shape or descriptor differs.
/// @param max_features  max_features; 0 = all
Method extraction(const std::string& features, const cv::Size& size, int max_features, int threads);

/// The same by cv::SIFT, cv::ORB or cv::AffineFeature of cv::SIFT, for "sift+sift", "orb+orb" and
/// "asift+asift". An OpenCV that lacks it is reported as a failure of the method.
Method openCvExtraction(const std::string& features, const cv::Size& size, int max_features);

/// The stages of a pair of photographs, from images to a selection by usac: features, matching, selection.
/// Each is timed on the results of those before.
std::vector<Method> pairStages(const std::string& features, const cv::Size& size, int max_features);

/// One image, by the work that it takes: the search for keypoints (all that is needed for a single feature),
/// the whole detection, and detection with description. The differences are what the stages cost.
std::vector<Method> costStages(const std::string& features, const cv::Size& size);

}  // namespace corrsel::performance
