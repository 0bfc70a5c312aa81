#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "corrsel/image_pair.h"

namespace corrsel::core {

/// Two photographs of the sample set. Their ground truth was derived from Debian's images by
/// scripts/maintenance/sample_truth.py, and is part of the source:
/// - "rig/01" to "rig/14": raw images of a stereo rig, which was calibrated from the chessboard that they
/// show.
///   The truth is the essential matrix, because the lenses distort. Like every truth of epipolar geometry, it
///   does not notice a wrong match along the epipolar curve. View 05 is left out, because its matches agree
///   with the truth little more often than chance does; there is no view 10.
/// - "box/1-2", "page/5-6": a plane, with its homography. In the first one, the left image shows nothing but
///   the plane, a part of which is covered in the right image.
struct RealSample {
  const char *sequence, *pair, *left, *right;  ///< the latter two are names of files
};

const std::vector<RealSample>& realSamples();

/// Adds the ground truth and, of the rig, the cameras to a pair whose images have been read.
/// Throws DatasetError naming the file whose image has another size than the truth is for.
/// @param sample  one of realSamples()
/// @param root    the folder of the images, for the error
void addRealTruth(const RealSample& sample, const std::string& root, const std::string& remedy,
                  ImagePair& pair);

}  // namespace corrsel::core
