#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/features/features.h"
#include "corrsel/options.h"

namespace corrsel::core {

/// Detects keypoints and describes them. extract() is const and re-entrant.
class FeatureExtractor {
 public:
  virtual ~FeatureExtractor() = default;

  /// @param image  8-bit, 1, 3 (BGR) or 4 (BGRA) channels. A blank or tiny image gives zero features.
  /// @return features in a fixed order (strongest first), at most max_features where the option is not 0.
  /// Throws std::invalid_argument for an empty image or another depth, naming what it got.
  virtual Features extract(const cv::Mat& image) const = 0;

  /// "detector+descriptor".
  virtual std::string name() const = 0;

  virtual const OptionSet& options() const = 0;
};

/// Creates an extractor from "detector+descriptor". Throws std::invalid_argument for an unknown combination
/// (listing the valid ones) and for options out of range.
std::unique_ptr<FeatureExtractor> createExtractor(const std::string& name, const OptionMap& options = {});

std::vector<std::string> extractorNames();

/// Extracts both images, side by side when threads > 1. The result does not depend on the thread count.
std::pair<Features, Features> extractPair(const FeatureExtractor& extractor, const cv::Mat& left,
                                          const cv::Mat& right, int threads);

}  // namespace corrsel::core
