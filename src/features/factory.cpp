#include <algorithm>
#include <stdexcept>

#include "base/text.h"
#include "corrsel/features/extractor.h"
#include "features/descriptors/freak.h"
#include "features/descriptors/patch_sift.h"
#include "features/detectors/akaze.h"
#include "features/detectors/asift.h"
#include "features/detectors/blob.h"
#include "features/detectors/brisk.h"
#include "features/detectors/hessian_affine.h"
#include "features/detectors/orb.h"
#include "features/detectors/sift.h"

namespace corrsel::core {
namespace {

/// An algorithm: its options and what it can be. The one place where it is announced.
struct Algorithm {
  std::string name;
  std::unique_ptr<OptionSet> (*options)();
  std::unique_ptr<Detector> (*detector)(const OptionSet& options);      ///< null: no detector
  std::unique_ptr<Descriptor> (*descriptor)(const OptionSet& options);  ///< null: no descriptor of other
                                                                        ///< detectors' keypoints
  bool self_describing = false;  ///< describes its own keypoints while it detects them
};

template <class O>
std::unique_ptr<OptionSet> optionsOf() {
  return std::make_unique<O>();
}

template <class D, class O>
std::unique_ptr<Detector> detectorOf(const OptionSet& options) {
  return std::make_unique<D>(dynamic_cast<const O&>(options));
}

template <class D, class O>
std::unique_ptr<Descriptor> descriptorOf(const OptionSet& options) {
  return std::make_unique<D>(dynamic_cast<const O&>(options));
}

const std::vector<Algorithm>& algorithms() {
  static const std::vector<Algorithm> table = {
      {"hessian_affine", optionsOf<HessianAffineOptions>,
       detectorOf<HessianAffineDetector, HessianAffineOptions>, nullptr},
      {"sift", optionsOf<SiftOptions>, detectorOf<SiftDetector, SiftOptions>,
       descriptorOf<PatchSift, SiftOptions>, true},
      {"orb", optionsOf<OrbOptions>, detectorOf<OrbDetector, OrbOptions>,
       descriptorOf<OrbDescriptor, OrbOptions>, true},
      {"asift", optionsOf<AsiftOptions>, detectorOf<AsiftDetector, AsiftOptions>, nullptr, true},
      {"blob", optionsOf<BlobOptions>, detectorOf<BlobDetector, BlobOptions>, nullptr},
      {"freak", optionsOf<FreakOptions>, nullptr, descriptorOf<FreakDescriptor, FreakOptions>},
      {"akaze", optionsOf<AkazeOptions>, detectorOf<AkazeDetector, AkazeOptions>, nullptr, true},
      {"brisk", optionsOf<BriskOptions>, detectorOf<BriskDetector, BriskOptions>,
       descriptorOf<BriskDescriptor, BriskOptions>, true},
  };
  return table;
}

/// Those that describe the keypoints of any detector.
std::vector<std::string> freeDescriptors() {
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

std::unique_ptr<OptionSet> optionsFor(const Algorithm& algorithm, const AlgorithmOptions& given) {
  std::unique_ptr<OptionSet> options = algorithm.options();
  const auto found = given.find(algorithm.name);
  if (found != given.end()) setOptions(*options, found->second, algorithm.name);
  try {
    options->check();
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument(algorithm.name + ": " + error.what());
  }
  return options;
}

}  // namespace

std::unique_ptr<FeatureExtractor> createExtractor(const std::string& name, const AlgorithmOptions& options) {
  const std::size_t plus = name.find('+');
  const std::string first = name.substr(0, plus);
  const std::string second = plus == std::string::npos ? "" : name.substr(plus + 1);
  const Algorithm *detector = find(first), *descriptor = find(second);
  const std::vector<std::string> detectors = detectorNames(), descriptors = descriptorNames();
  const auto among = [](const std::vector<std::string>& names, const std::string& wanted) {
    return std::find(names.begin(), names.end(), wanted) != names.end();
  };
  if (!among(detectors, first) || !among(descriptors, second)) {
    throw std::invalid_argument("unknown features '" + name + "'; valid: detector+descriptor, e.g. " +
                                joinList(extractorNames()) + "; detectors: " + joinList(detectors) +
                                "; descriptors: " + joinList(descriptors));
  }
  if (detector == descriptor && detector->self_describing) {
    return std::make_unique<FeatureExtractor>(name, detector->detector(*optionsFor(*detector, options)),
                                              nullptr);
  }
  if (descriptor->descriptor == nullptr) {
    throw std::invalid_argument("features '" + name + "' cannot work: the " + second +
                                " descriptor needs what the " + second + " detector finds on the way; use " +
                                second + "+" + second + ", or with " + first + " one of " +
                                joinList(freeDescriptors()));
  }
  return std::make_unique<FeatureExtractor>(name, detector->detector(*optionsFor(*detector, options)),
                                            descriptor->descriptor(*optionsFor(*descriptor, options)));
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

std::vector<std::pair<std::string, std::unique_ptr<OptionSet>>> featureAlgorithms() {
  std::vector<std::pair<std::string, std::unique_ptr<OptionSet>>> result;
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
