#pragma once

#include <string>

#include "datasets/posed_pairs.h"

namespace corrsel::core {

/// Finds pairs in reconstructions by COLMAP (Schoenberger, Frahm, Structure-from-motion revisited, CVPR
/// 2016). A scene is a folder, or the root itself, with a sparse model in `sparse/0`, `sparse` or the folder
/// itself (readColmapModel()), and `images/` with the images that the model names.
///
/// The pairs are all pairs of images that see at least PairChoice::min_points common 3D points. Where they
/// are more than PairChoice::max_pairs, as many are taken evenly from the list in the order of the number of
/// common points, so that pairs with much and with little overlap are there in the shares that the scene has.
/// The pose is known up to scale.
///
/// Camera models are those of cameraFromColmap(). The pairs of another camera are broken.
/// A scene that cannot be read is one broken pair.
PosedDataset readColmap(const std::string& name, const std::string& root);

/// Whether the root is a scene or holds one.
bool hasColmap(const std::string& root);

}  // namespace corrsel::core
