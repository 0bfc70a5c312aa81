#pragma once

#include <opencv2/core/mat.hpp>
#include <string>

namespace corrsel::performance {

/// Two grey photographs of one scene.
struct Picture {
  cv::Mat left, right;
};

/// Folders with photographs.
struct PictureFolders {
  std::string samples;    ///< that of scripts/fetch_samples.sh
  std::string data_root;  ///< with the datasets vgg and kitti_stereo; empty: only the samples are used
};
void setPictureFolders(const PictureFolders& folders);

/// - 800x640: graf, images 1 and 3 of the samples, or 1 and 2 of VGG;
/// - 640x480: aloe of the samples, scaled;
/// - 1392x512: the first stereo pair of KITTI, or a part of aloe, scaled.
///
/// The first use reads the files. Throws std::runtime_error naming the file that is missing and the remedy,
/// and std::invalid_argument for other sizes.
const Picture& picture(const cv::Size& size);

}  // namespace corrsel::performance
