#pragma once

#include <functional>
#include <opencv2/features2d.hpp>
#include <string>

#include "corrsel/features/extractor.h"

namespace corrsel::core {

/// A detector and descriptor of OpenCV's features2d behind the FeatureExtractor contract: grey conversion,
/// blank and tiny images, a fixed order of features, the cap, and the seconds of each stage.
class OpenCvExtractor : public FeatureExtractor {
 public:
  using Create = std::function<cv::Ptr<cv::Feature2D>(const cv::Size& image_size)>;

  /// @param create        makes the algorithm for an image size; called once per extract(), since OpenCV's
  /// objects keep state
  /// @param max_features  strongest kept, 0 = no cap
  /// @param border        features closer to the image border than this are beyond the descriptor, px
  OpenCvExtractor(std::string name, Create create, int max_features, int border);

  Features extract(const cv::Mat& image) const override;
  std::string name() const override { return name_; }

 private:
  std::string name_;
  Create create_;
  int max_features_, border_;
};

}  // namespace corrsel::core
