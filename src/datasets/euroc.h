#pragma once

#include <string>

#include "datasets/posed_pairs.h"

namespace corrsel::core {

/// Finds pairs in sequences of the EuRoC MAV dataset (Burri et al., The EuRoC micro aerial vehicle datasets,
/// IJRR 2016). A sequence is a folder, or the root itself, with `mav0/` (ASL format):
/// - `cam0/data.csv`, `cam1/data.csv`: lines `timestamp [ns],filename`, of images in `data/` beside it;
/// - `cam0/sensor.yaml`, `cam1/sensor.yaml`: `T_BS` (from the camera's frame to the body's), `intrinsics`,
///   `distortion_coefficients` (or `distortion_coeffs`), `resolution`, `camera_model` and `distortion_model`,
///   in the words of EuRoC or of Kalibr (cameraFromKalibr());
/// - `state_groundtruth_estimate0/data.csv`: the pose of the body in the world, timestamp [ns], position [m],
///   quaternion w x y z, and columns that are not used. Its sensor.yaml may have a T_BS, too, which relates
///   the body of the ground truth to that of the cameras.
///
/// Pairs are images of both cameras at one time ("stereo": the truth is the calibration of the rig) and
/// images of cam0 that are `step` frames apart ("steps": the pose is interpolated); PairChoice::pairs
/// chooses. Of one camera or without ground truth, those that are possible are made, and a remark says so. A
/// sequence that cannot be read is one broken pair.
PosedDataset readEuroc(const std::string& name, const std::string& root);

/// Whether the root is a sequence or holds one.
bool hasEuroc(const std::string& root);

}  // namespace corrsel::core
