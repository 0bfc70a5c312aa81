#pragma once

#include <string>

#include "datasets/posed_pairs.h"

namespace corrsel::core {

/// Finds the pairs of a list in the form in which SuperGlue (Sarlin et al., CVPR 2020) publishes those of
/// ScanNet, MegaDepth and YFCC: `<root>/pairs.txt`, or any other name that is the only list there, with a
/// line
///
///   image_a image_b turns_a turns_b K_a K_b T_ab
///
/// for each pair. The images are paths below the root; turns are the quarter turns counter-clockwise (0 to 3)
/// by which an image is turned before use, as its Exif data asks for; K_a and K_b are the camera matrices of
/// the stored images, nine numbers each; T_ab has 16 numbers, row by row, and maps the frame of camera a to
/// that of camera b. K and T are those of the images before they are turned, as in SuperGlue's
/// match_pairs.py, whose functions rotate_intrinsics() and rotate_pose_inplane() state how both change.
///
/// A line that cannot be used is a broken pair. A sequence is the folder of the left image, with '_' in place
/// of '/'; without a folder it is the name of the list.
/// Throws DatasetError where no line has a pose (the lists without ground truth have two or four entries).
PosedDataset readPairList(const std::string& name, const std::string& root);

/// Whether the folder has such a list.
bool hasPairList(const std::string& root);

}  // namespace corrsel::core
