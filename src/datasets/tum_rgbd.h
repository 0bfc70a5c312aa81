#pragma once

#include <string>

#include "datasets/posed_pairs.h"

namespace corrsel::core {

/// Finds pairs in sequences of the TUM RGB-D benchmark (Sturm, Engelhard, Endres, Burgard, Cremers, A
/// benchmark for the evaluation of RGB-D SLAM systems, IROS 2012). A sequence is a folder, or the root
/// itself, with
/// - `rgb.txt`: lines `timestamp path`, the path relative to the sequence;
/// - `groundtruth.txt`: lines `timestamp tx ty tz qx qy qz qw`, the pose of the colour camera in the world,
/// m;
/// - `calibration.txt`, optional: fx fy cx cy [k1 k2 p1 p2 [k3]], px. Without it the folder's name must
/// contain
///   freiburg1, freiburg2 or freiburg3 (or fr1_, fr2_, fr3_), whose published calibration is used.
///
/// Pairs are images `step` frames apart (PairChoice). The pose of an image is interpolated. Depth is not
/// used. A sequence that cannot be read is one broken pair.
PosedDataset readTumRgbd(const std::string& name, const std::string& root);

/// Whether the root is a sequence or holds one.
bool hasTumRgbd(const std::string& root);

}  // namespace corrsel::core
