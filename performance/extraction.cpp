#include "extraction.h"

#include <cstring>
#include <memory>
#include <opencv2/features2d.hpp>
#include <stdexcept>
#include <utility>

#include "corrsel/features/extractor.h"
#include "corrsel/matching/matcher.h"
#include "corrsel/selectors/factory.h"
#include "features/detectors/asift.h"
#include "features/detectors/hessian_affine.h"
#include "features/detectors/orb.h"
#include "features/detectors/sift.h"
#include "opencv_version.h"
#include "pictures.h"

namespace corrsel::performance {
namespace {

SceneSpec spec(int max_features) { return {MatchSceneKind::kPlane, std::size_t(max_features), kNotMeasured}; }

Mask outcome(const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& descriptors) {
  Mask bytes(keypoints.size() * kFeatureBytes);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const cv::KeyPoint& k = keypoints[i];
    // Eight bytes at a time, because this is a part of the time that is measured.
    std::uint64_t sum = 1, word = 0;
    const std::uint8_t* row = descriptors.ptr(int(i));
    for (std::size_t b = 0; b < std::size_t(descriptors.cols) * descriptors.elemSize(); b += sizeof word) {
      std::memcpy(&word, row + b, sizeof word);
      sum = 31 * sum + (word ^ (word >> 32));
    }
    const float values[] = {k.pt.x, k.pt.y, k.size, k.angle, k.response};
    const auto checksum = static_cast<std::uint32_t>(sum ^ (sum >> 32));
    static_assert(sizeof values + sizeof checksum == kFeatureBytes);
    std::memcpy(bytes.data() + i * kFeatureBytes, values, sizeof values);
    std::memcpy(bytes.data() + i * kFeatureBytes + sizeof values, &checksum, sizeof checksum);
  }
  return bytes;
}

core::AlgorithmOptions limited(const std::string& features, int max_features) {
  if (max_features == 0) return {};
  return {{core::algorithmsOf(features).front(), {{"max_features", std::to_string(max_features)}}}};
}

cv::Ptr<cv::Feature2D> createOpenCv(const std::string& features, int max_features) {
  if (features == "orb+orb") return cv::ORB::create(max_features);
#if CORRSEL_OPENCV_AT_LEAST(4, 4)
  if (features == "sift+sift") return cv::SIFT::create(max_features);
#endif
#if CORRSEL_OPENCV_AT_LEAST(4, 5)
  if (features == "asift+asift") return cv::AffineFeature::create(cv::SIFT::create(max_features));
#endif
  throw std::runtime_error("OpenCV " CV_VERSION " has nothing like " + features);
}

const char* openCvName(const std::string& features) {
  return features == "orb+orb" ? "cv::ORB" : features == "sift+sift" ? "cv::SIFT" : "cv::AffineFeature";
}

template <class Detector, class Options>
std::unique_ptr<core::Detector> limitedDetector(int max_features) {
  Options options;
  if (max_features > 0) options.max_features = max_features;
  return std::make_unique<Detector>(options);
}

std::unique_ptr<core::Detector> createDetector(const std::string& features, int max_features) {
  const std::string name = core::algorithmsOf(features).front();
  if (name == "sift") return limitedDetector<core::SiftDetector, core::SiftOptions>(max_features);
  if (name == "orb") return limitedDetector<core::OrbDetector, core::OrbOptions>(max_features);
  if (name == "asift") return limitedDetector<core::AsiftDetector, core::AsiftOptions>(max_features);
  if (name == "hessian_affine") {
    return limitedDetector<core::HessianAffineDetector, core::HessianAffineOptions>(max_features);
  }
  throw std::invalid_argument("no stages are known for " + name);
}

}  // namespace

Method extraction(const std::string& features, const cv::Size& size, int max_features, int threads) {
  const std::string name = features + (threads > 1 ? ", " + std::to_string(threads) + " threads" : "");
  return {name, spec(max_features), 1, [=](const std::vector<Scene>&) -> Call {
            const std::shared_ptr<const core::FeatureExtractor> extractor =
                core::createExtractor(features, limited(features, max_features));
            const cv::Mat image = picture(size).left;
            return [=](std::size_t) {
              const core::Features found = extractor->extract(image, threads);
              return outcome(found.keypoints, found.descriptors);
            };
          }};
}

Method openCvExtraction(const std::string& features, const cv::Size& size, int max_features) {
  return {openCvName(features), spec(max_features), 1, [=](const std::vector<Scene>&) -> Call {
            const cv::Ptr<cv::Feature2D> algorithm = createOpenCv(features, max_features);
            const cv::Mat image = picture(size).left;
            return [=](std::size_t) {
              std::vector<cv::KeyPoint> keypoints;
              cv::Mat descriptors;
              algorithm->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
              return outcome(keypoints, descriptors);
            };
          }};
}

std::vector<Method> pairStages(const std::string& features, const cv::Size& size, int max_features) {
  const auto extract = [=] {
    const auto extractor = core::createExtractor(features, limited(features, max_features));
    return core::extractPair(*extractor, picture(size).left, picture(size).right, 1);
  };
  const auto bytes = [](std::size_t n) { return Mask(n, 1); };
  return {
      {features, spec(max_features), 1,
       [=](const std::vector<Scene>&) -> Call {
         const std::shared_ptr<const core::FeatureExtractor> extractor =
             core::createExtractor(features, limited(features, max_features));
         const Picture images = picture(size);
         return [=](std::size_t) {
           return bytes(core::extractPair(*extractor, images.left, images.right, 1).first.keypoints.size());
         };
       }},
      {"matching", spec(max_features), 1,
       [=](const std::vector<Scene>&) -> Call {
         const auto found = extract();
         return [=](std::size_t) { return bytes(core::matchFeatures(found.first, found.second).size()); };
       }},
      {"usac", spec(max_features), 1, [=](const std::vector<Scene>&) -> Call {
         const auto found = extract();
         const core::Correspondences matches = core::matchFeatures(found.first, found.second);
         const std::shared_ptr<const core::Selector> selector =
             core::createSelector("usac", {}, {{"threads", "1"}});
         return [=](std::size_t) { return selector->select(matches).mask; };
       }}};
}

std::vector<Method> costStages(const std::string& features, const cv::Size& size) {
  const auto detection = [=](const std::string& name, int max_features) -> Method {
    return {name, spec(max_features), 1, [=](const std::vector<Scene>&) -> Call {
              const std::shared_ptr<const core::Detector> detector = createDetector(features, max_features);
              const cv::Mat image = picture(size).left;
              return [=](std::size_t) {
                core::Features found;
                detector->detect({image}, found);
                return Mask(found.keypoints.size(), 1);
              };
            }};
  };
  return {detection("search", 1), detection("detection", 0), extraction(features, size, 0, 1)};
}

}  // namespace corrsel::performance
