#pragma once

#include <functional>
#include <opencv2/features2d.hpp>
#include <string>
#include <vector>

#include "features/detectors/detector.h"

namespace corrsel::core {

/// Creates an algorithm of OpenCV for an image size. It is called once per image, since OpenCV's objects keep
/// state and are not re-entrant.
/// @param max_features  the algorithm may keep only this number of the strongest features; 0 = it keeps all
using CreateOpenCv = std::function<cv::Ptr<cv::Feature2D>(const cv::Size& image_size, int max_features)>;

/// A detector of OpenCV's features2d that describes its keypoints too.
///
/// Threads: OpenCV uses its own threads; DetectionRequest::threads is not used.
///
/// Masks: OpenCV's own masks are not used, because its SIFT applies them after its limit on the number of
/// features, and its ORB lets their holes grow from level to level. Instead the algorithm is asked for more
/// features, and masked ones are dropped; where too few remain, it runs again with a larger number.
class OpenCvDetector : public Detector {
 public:
  /// @param border      images of at most twice this size have no features, px
  /// @param size_factor  diameter of what is detected, divided by the algorithm's keypoint size, which may be
  /// that of its descriptor's patch. It is applied to keypoints that another descriptor will describe.
  OpenCvDetector(std::string name, CreateOpenCv create, int border, double size_factor = 1);

  void detect(const DetectionRequest& request, Features& features) const override;
  bool describesKeypoints() const override { return true; }
  std::string name() const override { return name_; }

 protected:
  /// How many features the algorithm keeps of each octave, or of all octaves in one number, when it may keep
  /// `max_features`. Empty: it always keeps all.
  virtual std::vector<int> shares(const cv::Size& image_size, int max_features) const;

 private:
  int limit() const;
  void run(const DetectionRequest& request, int max_features, Features& features) const;
  void runMasked(const DetectionRequest& request, Features& features) const;

  std::string name_;
  CreateOpenCv create_;
  int border_;
  double size_factor_;
};

}  // namespace corrsel::core
