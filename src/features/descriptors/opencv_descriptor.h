#pragma once

#include <functional>
#include <string>

#include "features/descriptors/descriptor.h"
#include "features/detectors/opencv_detector.h"

namespace corrsel::core {

/// A descriptor of OpenCV's features2d for keypoints of any detector.
class OpenCvDescriptor : public Descriptor {
 public:
  /// Sets the octave or size that the algorithm expects of a keypoint of another detector.
  using Prepare = std::function<void(const cv::Size& image_size, cv::KeyPoint& keypoint)>;

  /// @param border  images of at most twice this size have no features, px
  OpenCvDescriptor(std::string name, CreateOpenCv create, int border, Prepare prepare);

  void describe(const cv::Mat& grey, int threads, Workspace& workspace, Features& features) const override;
  std::string name() const override { return name_; }

 private:
  std::string name_;
  CreateOpenCv create_;
  int border_;
  Prepare prepare_;
};

}  // namespace corrsel::core
