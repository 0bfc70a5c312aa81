#pragma once

#include <functional>
#include <opencv2/features2d.hpp>
#include <string>

#include "corrsel/features/descriptor.h"
#include "corrsel/features/detector.h"

namespace corrsel::core {

/// A detector of OpenCV's features2d that describes its keypoints too.
class OpenCvDetector : public SelfDescribingDetector {
 public:
  /// Makes the algorithm for an image size; called once per image, since OpenCV's objects keep state.
  /// @param capped  it may keep the strongest max_features itself
  using Create = std::function<cv::Ptr<cv::Feature2D>(const cv::Size& image_size, bool capped)>;

  /// @param border       images of at most twice this size have no features, px
  /// @param size_factor  from the algorithm's keypoint size, which may be that of its descriptor's patch, to
  /// the diameter of what is detected; applied by detect() only, so that other descriptors get comparable
  /// sizes
  OpenCvDetector(std::string name, Create create, int border, double size_factor = 1);

  void detect(const cv::Mat& grey, int threads, Features& features) const override;
  void detectAndDescribe(const cv::Mat& grey, int threads, Features& features) const override;
  void detectWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                   Features& features) const override;
  void detectAndDescribeWhere(const cv::Mat& grey, int threads, const PlaceFilter& allowed,
                              Features& features) const override;
  std::string name() const override { return name_; }

 private:
  void run(const cv::Mat& grey, bool capped, bool describe, Features& features) const;

  std::string name_;
  Create create_;
  int border_;
  double size_factor_;
};

/// A descriptor of OpenCV's features2d for keypoints of any detector.
class OpenCvDescriptor : public Descriptor {
 public:
  /// Gives a keypoint of another detector the octave or size that the algorithm expects.
  using Prepare = std::function<void(const cv::Size& image_size, cv::KeyPoint& keypoint)>;

  /// @param border   images of at most twice this size have no features, px
  OpenCvDescriptor(std::string name, OpenCvDetector::Create create, int border, Prepare prepare);

  void describe(const cv::Mat& grey, int threads, Features& features) const override;
  std::string name() const override { return name_; }

 private:
  std::string name_;
  OpenCvDetector::Create create_;
  int border_;
  Prepare prepare_;
};

}  // namespace corrsel::core
