#pragma once

#include <opencv2/core/mat.hpp>

namespace corrsel::core {

/// Turns SIFT descriptors into RootSIFT: every row d becomes sqrt(d / sum(d)), whose Euclidean distance is
/// the Hellinger distance of the original rows. The values are multiplied by 512 and rounded to whole numbers
/// from 0 to 255, as SIFT's are. Rows of zeros stay as they are. O(rows * columns).
///
/// Source: Arandjelovic and Zisserman, "Three things everyone should know to improve object retrieval", CVPR
/// 2012, section 3.
///
/// @param descriptors  N x 128, CV_32F, not negative; changed in place
void toRootSift(cv::Mat& descriptors);

}  // namespace corrsel::core
