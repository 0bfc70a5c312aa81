#pragma once

#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <utility>
#include <vector>

#include "corrsel/features/features.h"
#include "corrsel/features/region.h"
#include "corrsel/options.h"

namespace corrsel::core {

class Descriptor;
class Detector;

/// Options by the name of the algorithm they belong to: {"orb": {"levels": "4"}}.
using AlgorithmOptions = std::map<std::string, OptionMap>;

/// A detector with a descriptor: what is common to all combinations. extract() is const and re-entrant.
class FeatureExtractor {
 public:
  /// @param descriptor  null: the detector describes its keypoints itself (a SelfDescribingDetector)
  FeatureExtractor(std::string name, std::unique_ptr<Detector> detector,
                   std::unique_ptr<Descriptor> descriptor);
  ~FeatureExtractor();

  /// @param image    8-bit, 1, 3 (BGR) or 4 (BGRA) channels. A blank or tiny image gives zero features.
  /// @param threads  threads that may be used; the result does not depend on it
  /// @param region   where features are looked for. The area is treated as an image of its own, to which
  /// max_megapixels and spread apply and whose border costs features as any border does; it takes the time of
  /// an image of its size. Masked features are dropped before max_features is applied. The region of the
  /// whole image, and a mask without zeros in the area, give the features that no region gives, bit for bit.
  /// @return features in a fixed order (strongest first), at most max_features where the option is not 0, in
  /// coordinates of the whole image.
  /// Throws std::invalid_argument for an empty image or another depth, an area outside the image, and a mask
  /// of another type or size, naming what it got.
  Features extract(const cv::Mat& image, int threads = 1, const FeatureRegion& region = {}) const;

  /// "detector+descriptor".
  const std::string& name() const { return name_; }

  /// The options in force, by algorithm: one entry where detector and descriptor are one algorithm, else two.
  std::vector<std::pair<std::string, const OptionSet*>> options() const;

 private:
  std::string name_;
  std::unique_ptr<Detector> detector_;
  std::unique_ptr<Descriptor> descriptor_;
};

/// Creates an extractor from "detector+descriptor"; options of other algorithms are not looked at. Throws
/// std::invalid_argument for names that do not exist (listing those that do), for pairings that cannot work
/// (saying why), and for options out of range.
std::unique_ptr<FeatureExtractor> createExtractor(const std::string& name,
                                                  const AlgorithmOptions& options = {});

/// The combinations of the paper, the default first, then the other algorithms that do both. Any other
/// pairing of detectorNames() and descriptorNames() works too, unless createExtractor() says why not.
std::vector<std::string> extractorNames();

/// A combination of extractorNames() with a few words about it.
struct FeatureCombination {
  std::string name, meaning;
};

const std::vector<FeatureCombination>& featureCombinations();

std::vector<std::string> detectorNames();
std::vector<std::string> descriptorNames();

/// Every algorithm with options, detector or descriptor or both, with its default options.
std::vector<std::pair<std::string, std::unique_ptr<OptionSet>>> featureAlgorithms();

/// The algorithms that a combination is made of: "sift+freak" gives sift and freak, "orb+orb" gives orb.
std::vector<std::string> algorithmsOf(const std::string& name);

/// Extracts both images, side by side when threads > 1. The result does not depend on the thread count.
std::pair<Features, Features> extractPair(const FeatureExtractor& extractor, const cv::Mat& left,
                                          const cv::Mat& right, int threads,
                                          const FeatureRegion& left_region = {},
                                          const FeatureRegion& right_region = {});

}  // namespace corrsel::core
