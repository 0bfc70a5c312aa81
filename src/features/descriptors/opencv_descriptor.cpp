#include "features/descriptors/opencv_descriptor.h"

#include <utility>
#include <vector>

#include "features/parts/feature_list.h"
#include "features/parts/grey_image.h"

namespace corrsel::core {

OpenCvDescriptor::OpenCvDescriptor(std::string name, CreateOpenCv create, int border, Prepare prepare)
    : name_(std::move(name)), create_(std::move(create)), border_(border), prepare_(std::move(prepare)) {}

void OpenCvDescriptor::describe(const cv::Mat& grey, int, Workspace&, Features& features) const {
  if (grey.cols <= 2 * border_ || grey.rows <= 2 * border_) {
    keepFeatures(std::vector<char>(features.keypoints.size(), 0), features);
  }
  if (features.keypoints.empty()) return;
  // OpenCV drops keypoints near the border and changes the order of the others; class_id identifies them.
  std::vector<cv::KeyPoint> keypoints = features.keypoints;
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    keypoints[i].class_id = static_cast<int>(i);
    prepare_(grey.size(), keypoints[i]);
  }
  cv::Mat descriptors;
  create_(grey.size(), 0)->compute(detached(grey), keypoints, descriptors);
  std::vector<char> keep(features.keypoints.size(), 0);
  std::vector<int> row_of(keep.size());
  for (std::size_t row = 0; row < keypoints.size(); ++row) {
    const auto i = static_cast<std::size_t>(keypoints[row].class_id);
    keep[i] = 1;
    row_of[i] = static_cast<int>(row);
  }
  keepFeatures(keep, features);
  features.descriptors.create(static_cast<int>(keypoints.size()), descriptors.cols, descriptors.type());
  int kept = 0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (keep[i]) descriptors.row(row_of[i]).copyTo(features.descriptors.row(kept++));
  }
}

}  // namespace corrsel::core
