#pragma once

#include <functional>
#include <opencv2/core/mat.hpp>
#include <string>

#include "corrsel/image_pair.h"

namespace corrsel::core {

/// An image that can be read in two ways.
struct StoredImage {
  std::string name;  ///< file or topic
  /// Returns it with one, three (BGR) or four (BGRA) channels. @param all_bits  false: as 8 bits, true: with
  /// its values, where these have 16 bits
  std::function<cv::Mat(bool all_bits)> read;
};

/// Reads both images of a pair as 8 bits with one or three channels. Images of 16 bits that use fewer of them
/// are scaled by the number of bits that the larger value of the two needs, so that they stay comparable and
/// the result depends on nothing but the pair; pair.stretched then describes it. Where they use all bits, the
/// reader scales them. Throws what `read` throws.
void readStretched(const StoredImage& left, const StoredImage& right, ImagePair& pair);

}  // namespace corrsel::core
