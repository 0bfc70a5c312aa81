#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "corrsel/camera_formats.h"
#include "geometry/rigid_motion.h"

namespace corrsel::core {

/// A camera of a sparse model of COLMAP.
struct ColmapModelCamera {
  std::int64_t id = 0;
  ColmapCamera camera;
  std::string place;  ///< file and line, or file alone, for error texts
};

/// An image of a sparse model of COLMAP.
struct ColmapImage {
  std::int64_t id = 0, camera = 0;
  std::string name;                  ///< path below the folder of the images
  RigidMotion pose;                  ///< from the world's frame to the camera's
  std::vector<std::int64_t> points;  ///< ids of the 3D points that it sees, ascending, each once
  std::string place;                 ///< likewise
};

/// What COLMAP's format says about the cameras and images of a reconstruction
/// (https://colmap.github.io/format.html). The 3D points themselves are not read.
struct ColmapModel {
  std::vector<ColmapModelCamera> cameras;
  std::vector<ColmapImage> images;
};

/// Reads a model from `cameras` and `images` in a folder, .bin where both files are there, otherwise .txt.
/// Throws DatasetError naming the file, in text the line, and the fault: missing, cut off, or not of the
/// format.
ColmapModel readColmapModel(const std::string& folder);

/// The two files that readColmapModel() reads, whether or not they exist.
std::vector<std::string> colmapFiles(const std::string& folder);

/// Whether the folder has both files.
bool hasColmapModel(const std::string& folder);

}  // namespace corrsel::core
