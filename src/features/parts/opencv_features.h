#pragma once

#include <functional>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

#include "features/descriptors/descriptor.h"
#include "features/detectors/detector.h"

namespace corrsel::core {

/// A detector of OpenCV's features2d that describes its keypoints too.
class OpenCvDetector : public SelfDescribingDetector {
 public:
  /// Makes the algorithm for an image size; called once per image, since OpenCV's objects keep state.
  /// @param most  it may keep the strongest of that number itself; 0 = all
  using Create = std::function<cv::Ptr<cv::Feature2D>(const cv::Size& image_size, int most)>;

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

 protected:
  /// How many it keeps of each octave, or of all in one number, when it may keep `most`. Empty: it keeps all.
  virtual std::vector<int> shares(const cv::Size& image_size, int most) const;

 private:
  int cap() const;
  void run(const cv::Mat& grey, int most, bool describe, Features& features) const;
  void runWhere(const cv::Mat& grey, bool describe, const PlaceFilter& allowed, Features& features) const;

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
