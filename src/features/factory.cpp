#include <algorithm>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include "base/text.h"
#include "corrsel/features/extractor.h"
#include "features/descriptors/brisk.h"
#include "features/descriptors/freak.h"
#include "features/descriptors/orb.h"
#include "features/descriptors/patch_sift.h"
#include "features/detectors/akaze.h"
#include "features/detectors/asift.h"
#include "features/detectors/blob.h"
#include "features/detectors/brisk.h"
#include "features/detectors/cv_orb.h"
#include "features/detectors/cv_sift.h"
#include "features/detectors/hessian_affine.h"
#include "features/detectors/orb.h"
#include "features/detectors/sift.h"
#include "features/parts/image_options.h"

namespace corrsel::core {
namespace {

/// An algorithm, which is a detector, a descriptor or both.
struct Algorithm {
  std::string name;
  std::unique_ptr<OptionSet> (*options)();
  std::unique_ptr<Detector> (*detector)(const std::string& name, const AlgorithmOptions& given);  ///< or null
  /// For the keypoints of any detector; null where there is none.
  std::unique_ptr<Descriptor> (*descriptor)(const std::string& name, const AlgorithmOptions& given);
  bool self_describing = false;  ///< the detector describes its own keypoints
};

template <class Options>
Options optionsFrom(const std::string& name, const AlgorithmOptions& given) {
  Options options;
  const auto found = given.find(name);
  if (found != given.end()) setOptions(options, found->second, name);
  try {
    options.check();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(name + ": " + error.what());
  }
  return options;
}

/// @tparam DetectorType, DescriptorType  void where there is none
template <class Options, class DetectorType, class DescriptorType>
Algorithm algorithm(std::string name) {
  Algorithm result;
  result.name = std::move(name);
  result.options = []() -> std::unique_ptr<OptionSet> { return std::make_unique<Options>(); };
  result.detector = nullptr;
  result.descriptor = nullptr;
  if constexpr (!std::is_void_v<DetectorType>) {
    result.detector = [](const std::string& name, const AlgorithmOptions& given) {
      return std::unique_ptr<Detector>(std::make_unique<DetectorType>(optionsFrom<Options>(name, given)));
    };
    // The table needs no instance, since cv_sift cannot be created with every version of OpenCV: a detector
    // that overrides describesKeypoints() describes its keypoints.
    result.self_describing =
        !std::is_same_v<decltype(&DetectorType::describesKeypoints), decltype(&Detector::describesKeypoints)>;
  }
  if constexpr (!std::is_void_v<DescriptorType>) {
    result.descriptor = [](const std::string& name, const AlgorithmOptions& given) {
      return std::unique_ptr<Descriptor>(std::make_unique<DescriptorType>(optionsFrom<Options>(name, given)));
    };
  }
  return result;
}

/// The only place that lists the algorithms.
const std::vector<Algorithm>& algorithms() {
  static const std::vector<Algorithm> table = {
      algorithm<HessianAffineOptions, HessianAffineDetector, void>("hessian_affine"),
      algorithm<SiftOptions, SiftDetector, PatchSift>("sift"),
      algorithm<OrbOptions, OrbDetector, OrbDescriptor>("orb"),
      algorithm<AsiftOptions, AsiftDetector, void>("asift"),
      algorithm<BlobOptions, BlobDetector, void>("blob"),
      algorithm<FreakOptions, void, FreakDescriptor>("freak"),
      algorithm<AkazeOptions, AkazeDetector, void>("akaze"),
      algorithm<BriskOptions, BriskDetector, BriskDescriptor>("brisk"),
      algorithm<CvSiftOptions, CvSiftDetector, void>("cv_sift"),
      algorithm<CvOrbOptions, CvOrbDetector, void>("cv_orb"),
  };
  return table;
}

/// The descriptors that describe the keypoints of any detector.
std::vector<std::string> generalDescriptors() {
  std::vector<std::string> names;
  for (const Algorithm& algorithm : algorithms()) {
    if (algorithm.descriptor != nullptr) names.push_back(algorithm.name);
  }
  return names;
}

const Algorithm* find(const std::string& name) {
  for (const Algorithm& algorithm : algorithms()) {
    if (algorithm.name == name) return &algorithm;
  }
  return nullptr;
}

/// The descriptors that describe the keypoints of a detector; none for a name that is not a detector's.
std::vector<std::string> descriptorsFor(const std::string& detector) {
  const Algorithm* const algorithm = find(detector);
  if (algorithm == nullptr || algorithm->detector == nullptr) return {};
  std::vector<std::string> names = generalDescriptors();
  if (algorithm->self_describing && algorithm->descriptor == nullptr) names.push_back(detector);
  return names;
}

bool isOneOf(const std::vector<std::string>& names, const std::string& wanted) {
  return std::find(names.begin(), names.end(), wanted) != names.end();
}

/// The combination that is usual for one algorithm, e.g. blob+freak for blob and for freak; empty if none is.
std::string usualCombination(const std::string& name) {
  const std::string beginning = name + "+", end = "+" + name;
  for (const std::string& combination : extractorNames()) {
    if (combination.compare(0, beginning.size(), beginning) == 0) return combination;
  }
  for (const std::string& combination : extractorNames()) {
    const bool longer = combination.size() > end.size();
    if (longer && combination.compare(combination.size() - end.size(), end.size(), end) == 0) {
      return combination;
    }
  }
  return isOneOf(descriptorsFor(name), name) ? name + "+" + name : "";
}

/// The combination that is probably meant by `first`+`second` or, with an empty `second`, by `first` alone;
/// empty if none is near.
std::string nearestCombination(const std::string& first, const std::string& second) {
  std::vector<std::string> all;
  for (const Algorithm& algorithm : algorithms()) all.push_back(algorithm.name);
  if (second.empty()) return usualCombination(nearestName(first, all));
  const std::string detector = nearestName(first, detectorNames());
  const std::string descriptor = nearestName(second, descriptorsFor(detector));
  if (!descriptor.empty()) return detector + "+" + descriptor;
  return isOneOf(descriptorsFor(second), first) ? second + "+" + first : "";
}

}  // namespace

std::unique_ptr<FeatureExtractor> createExtractor(const std::string& name, const AlgorithmOptions& options) {
  const std::size_t plus = name.find('+');
  const std::string first = name.substr(0, plus);
  const std::string second = plus == std::string::npos ? "" : name.substr(plus + 1);
  const Algorithm *detector = find(first), *descriptor = find(second);
  const std::vector<std::string> detectors = detectorNames(), descriptors = descriptorNames();
  if (!isOneOf(detectors, first) || !isOneOf(descriptors, second)) {
    const std::string near = nearestCombination(first, second);
    throw std::invalid_argument(
        "unknown features '" + name + "';" + (near.empty() ? "" : " did you mean '" + near + "'?") +
        " valid: detector+descriptor, e.g. " + joinList(extractorNames()) +
        "; detectors: " + joinList(detectors) + "; descriptors: " + joinList(descriptors));
  }
  const auto image = optionsFrom<ImageOptions>(kImageOptions, options);
  if (detector == descriptor && detector->self_describing) {
    return std::make_unique<FeatureExtractor>(name, detector->detector(first, options), nullptr, image);
  }
  if (descriptor->descriptor == nullptr) {
    throw std::invalid_argument("features '" + name + "' cannot work: the descriptor " + second +
                                " describes only the keypoints of the detector " + second + "; use " +
                                second + "+" + second + ", or combine " + first +
                                " with one of the descriptors " + joinList(generalDescriptors()));
  }
  return std::make_unique<FeatureExtractor>(name, detector->detector(first, options),
                                            descriptor->descriptor(second, options), image);
}

const std::vector<FeatureCombination>& featureCombinations() {
  static const std::vector<FeatureCombination> table = {
      {"hessian_affine+sift", "Affine frames, float descriptors; the default of the paper"},
      {"sift+sift", "Scale-invariant, float descriptors compared by L2"},
      {"orb+orb", "Fast, binary descriptors compared by Hamming distance"},
      {"asift+asift", "SIFT in simulated views: strong changes of viewpoint, slow"},
      {"blob+freak", "Laplacian extrema with binary descriptors"},
      {"akaze+akaze", "Non-linear scale space, binary descriptors"},
      {"brisk+brisk", "Corners at all scales, binary descriptors"},
  };
  return table;
}

std::vector<std::string> extractorNames() {
  std::vector<std::string> names;
  for (const FeatureCombination& combination : featureCombinations()) names.push_back(combination.name);
  return names;
}

std::vector<std::string> detectorNames() {
  std::vector<std::string> names;
  for (const Algorithm& algorithm : algorithms()) {
    if (algorithm.detector != nullptr) names.push_back(algorithm.name);
  }
  return names;
}

std::vector<std::string> descriptorNames() {
  std::vector<std::string> names;
  for (const Algorithm& algorithm : algorithms()) {
    if (algorithm.self_describing || algorithm.descriptor != nullptr) names.push_back(algorithm.name);
  }
  return names;
}

std::vector<std::pair<std::string, std::string>> missingAlgorithms() {
  std::vector<std::pair<std::string, std::string>> result;
  for (const Algorithm& algorithm : algorithms()) {
    if (algorithm.detector == nullptr) continue;
    try {
      algorithm.detector(algorithm.name, {});
    } catch (const std::invalid_argument& error) {
      result.emplace_back(algorithm.name, error.what());
    }
  }
  return result;
}

std::vector<std::pair<std::string, std::unique_ptr<OptionSet>>> featureAlgorithms() {
  std::vector<std::pair<std::string, std::unique_ptr<OptionSet>>> result;
  result.emplace_back(kImageOptions, std::make_unique<ImageOptions>());
  for (const Algorithm& algorithm : algorithms()) result.emplace_back(algorithm.name, algorithm.options());
  return result;
}

std::vector<std::string> algorithmsOf(const std::string& name) {
  const std::size_t plus = name.find('+');
  std::vector<std::string> result = {name.substr(0, plus)};
  if (plus != std::string::npos && name.substr(plus + 1) != result.front()) {
    result.push_back(name.substr(plus + 1));
  }
  return result;
}

}  // namespace corrsel::core
