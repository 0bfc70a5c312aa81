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
struct ImageOptions;

/// Options by the name of the algorithm they belong to: {"orb": {"levels": "4"}}. Those under kImageOptions
/// belong to every combination: what is done to an image before features are searched.
using AlgorithmOptions = std::map<std::string, OptionMap>;

/// The name of the options that every combination has.
constexpr char kImageOptions[] = "image";

/// Extracts features with a detector and a descriptor. It converts colours, reduces large images, raises
/// contrast, applies regions, sorts the features and limits their number. extract() is const and re-entrant.
class FeatureExtractor {
 public:
  /// Applications use createExtractor().
  /// @param descriptor  null where the detector describes its keypoints itself
  /// @param image       what is done to every image first
  /// Throws std::invalid_argument where `descriptor` is null and the detector has no descriptor of its own.
  FeatureExtractor(std::string name, std::unique_ptr<Detector> detector,
                   std::unique_ptr<Descriptor> descriptor, const ImageOptions& image);
  ~FeatureExtractor();

  /// Finds and describes the features of an image.
  /// @param image   8 or 16 bits with 1 (grey), 3 (BGR) or 4 (BGRA) channels; rows may be padded. A grey
  /// image of 8 bits is used without a copy. A value v of 16 bits becomes v / 257, rounded, so that 65535
  /// becomes 255. A blank or tiny image has no features.
  /// @param threads  threads that may be used; the result does not depend on it
  /// @param region  the part of the image in which features are searched. Its area is treated as an image of
  /// its own: max_megapixels, equalize and spread apply to the area, its border costs features as the border
  /// of an image does, and the time is that of an image of its size. Masked features are dropped before
  /// max_features is applied. A region that is the whole image, and a mask without zeros in the area, give
  /// the same features as no region, bit for bit.
  /// @return features in a fixed order, strongest first, in px of the whole image; at most max_features where
  /// this option is not 0
  /// Memory for the conversion to grey is kept for the next call, in the workspace of the calling thread
  /// (corrsel/workspace.h). Throws std::invalid_argument for an empty image or one of another type, an area
  /// outside the image, and a mask of another type or size. The message names the value.
  Features extract(const cv::Mat& image, int threads = 1, const FeatureRegion& region = {}) const;

  /// As extract(), without descriptors. Features that the descriptor cannot describe remain.
  Features detect(const cv::Mat& image, int threads = 1, const FeatureRegion& region = {}) const;

  /// The size to which an image of this size is reduced before features are searched: its own, or a smaller
  /// one where it has more than the option max_megapixels.
  cv::Size searchedSize(const cv::Size& image) const;

  /// "detector+descriptor".
  const std::string& name() const { return name_; }

  /// The options in force, by algorithm: one entry where detector and descriptor are one algorithm, else two;
  /// then kImageOptions.
  std::vector<std::pair<std::string, const OptionSet*>> options() const;

 private:
  Features find(const cv::Mat& image, int threads, const FeatureRegion& region, bool describe) const;

  std::string name_;
  std::unique_ptr<Detector> detector_;
  std::unique_ptr<Descriptor> descriptor_;
  std::unique_ptr<const ImageOptions> image_;
};

/// Creates an extractor from "detector+descriptor". Options of other algorithms are ignored. Throws
/// std::invalid_argument for unknown names (the message lists the valid ones), for combinations that cannot
/// work (the message gives the reason), and for options that are unknown or out of range.
std::unique_ptr<FeatureExtractor> createExtractor(const std::string& name,
                                                  const AlgorithmOptions& options = {});

/// The combinations of the paper, the default first, then the other algorithms that detect and describe. Most
/// other combinations of detectorNames() and descriptorNames() work too; createExtractor() throws for those
/// that do not.
std::vector<std::string> extractorNames();

/// A combination of extractorNames() with a few words about it.
struct FeatureCombination {
  std::string name, meaning;
};

const std::vector<FeatureCombination>& featureCombinations();

std::vector<std::string> detectorNames();
std::vector<std::string> descriptorNames();

/// The algorithms that this version of OpenCV lacks, and why createExtractor() throws for them.
std::vector<std::pair<std::string, std::string>> missingAlgorithms();

/// The options of all combinations, kImageOptions, and every algorithm (detector, descriptor or both), with
/// their default values.
std::vector<std::pair<std::string, std::unique_ptr<OptionSet>>> featureAlgorithms();

/// The algorithms of a combination: "sift+freak" gives sift and freak, "orb+orb" gives orb.
std::vector<std::string> algorithmsOf(const std::string& name);

/// Extracts the features of both images, at the same time where threads > 1. The result does not depend on
/// the number of threads. Throws what extract() throws.
std::pair<Features, Features> extractPair(const FeatureExtractor& extractor, const cv::Mat& left,
                                          const cv::Mat& right, int threads,
                                          const FeatureRegion& left_region = {},
                                          const FeatureRegion& right_region = {});

}  // namespace corrsel::core
