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

SceneSpec spec(int most) { return {MatchSceneKind::kPlane, std::size_t(most), kNotMeasured}; }

Mask outcome(const std::vector<cv::KeyPoint>& keypoints, const cv::Mat& descriptors) {
  Mask bytes(keypoints.size() * kFeatureBytes);
  for (std::size_t i = 0; i < keypoints.size(); ++i) {
    const cv::KeyPoint& k = keypoints[i];
    std::uint32_t sum = 1;
    const std::uint8_t* row = descriptors.ptr(int(i));
    for (std::size_t b = 0; b < std::size_t(descriptors.cols) * descriptors.elemSize(); ++b) {
      sum = 31 * sum + row[b];
    }
    const float values[] = {k.pt.x, k.pt.y, k.size, k.angle, k.response};
    static_assert(sizeof values + sizeof sum == kFeatureBytes);
    std::memcpy(bytes.data() + i * kFeatureBytes, values, sizeof values);
    std::memcpy(bytes.data() + i * kFeatureBytes + sizeof values, &sum, sizeof sum);
  }
  return bytes;
}

core::AlgorithmOptions limited(const std::string& features, int most) {
  if (most == 0) return {};
  return {{core::algorithmsOf(features).front(), {{"max_features", std::to_string(most)}}}};
}

cv::Ptr<cv::Feature2D> createOpenCv(const std::string& features, int most) {
  if (features == "orb+orb") return cv::ORB::create(most);
#if CORRSEL_OPENCV_AT_LEAST(4, 4)
  if (features == "sift+sift") return cv::SIFT::create(most);
#endif
#if CORRSEL_OPENCV_AT_LEAST(4, 5)
  if (features == "asift+asift") return cv::AffineFeature::create(cv::SIFT::create(most));
#endif
  throw std::runtime_error("OpenCV " CV_VERSION " has nothing like " + features);
}

const char* openCvName(const std::string& features) {
  return features == "orb+orb" ? "cv::ORB" : features == "sift+sift" ? "cv::SIFT" : "cv::AffineFeature";
}

template <class Detector, class Options>
std::unique_ptr<core::Detector> limitedDetector(int most) {
  Options options;
  if (most > 0) options.max_features = most;
  return std::make_unique<Detector>(options);
}

std::unique_ptr<core::Detector> createDetector(const std::string& features, int most) {
  const std::string name = core::algorithmsOf(features).front();
  if (name == "sift") return limitedDetector<core::SiftDetector, core::SiftOptions>(most);
  if (name == "orb") return limitedDetector<core::OrbDetector, core::OrbOptions>(most);
  if (name == "asift") return limitedDetector<core::AsiftDetector, core::AsiftOptions>(most);
  if (name == "hessian_affine") {
    return limitedDetector<core::HessianAffineDetector, core::HessianAffineOptions>(most);
  }
  throw std::invalid_argument("no stages are known for " + name);
}

}  // namespace

Method extraction(const std::string& features, const cv::Size& size, int most, int threads) {
  const std::string name = features + (threads > 1 ? ", " + std::to_string(threads) + " threads" : "");
  return {name, spec(most), 1, [=](const std::vector<Scene>&) -> Call {
            const std::shared_ptr<const core::FeatureExtractor> extractor =
                core::createExtractor(features, limited(features, most));
            const cv::Mat image = picture(size).left;
            return [=](std::size_t) {
              const core::Features found = extractor->extract(image, threads);
              return outcome(found.keypoints, found.descriptors);
            };
          }};
}

Method openCvExtraction(const std::string& features, const cv::Size& size, int most) {
  return {openCvName(features), spec(most), 1, [=](const std::vector<Scene>&) -> Call {
            const cv::Ptr<cv::Feature2D> algorithm = createOpenCv(features, most);
            const cv::Mat image = picture(size).left;
            return [=](std::size_t) {
              std::vector<cv::KeyPoint> keypoints;
              cv::Mat descriptors;
              algorithm->detectAndCompute(image, cv::noArray(), keypoints, descriptors);
              return outcome(keypoints, descriptors);
            };
          }};
}

std::vector<Method> pairStages(const std::string& features, const cv::Size& size, int most) {
  const auto extract = [=] {
    const auto extractor = core::createExtractor(features, limited(features, most));
    return core::extractPair(*extractor, picture(size).left, picture(size).right, 1);
  };
  const auto bytes = [](std::size_t n) { return Mask(n, 1); };
  return {
      {features, spec(most), 1,
       [=](const std::vector<Scene>&) -> Call {
         const std::shared_ptr<const core::FeatureExtractor> extractor =
             core::createExtractor(features, limited(features, most));
         const Picture images = picture(size);
         return [=](std::size_t) {
           return bytes(core::extractPair(*extractor, images.left, images.right, 1).first.keypoints.size());
         };
       }},
      {"matching", spec(most), 1,
       [=](const std::vector<Scene>&) -> Call {
         const auto found = extract();
         return [=](std::size_t) { return bytes(core::matchFeatures(found.first, found.second).size()); };
       }},
      {"usac", spec(most), 1, [=](const std::vector<Scene>&) -> Call {
         const auto found = extract();
         const core::Correspondences matches = core::matchFeatures(found.first, found.second);
         const std::shared_ptr<const core::Selector> selector =
             core::createSelector("usac", {}, {{"threads", "1"}});
         return [=](std::size_t) { return selector->select(matches).mask; };
       }}};
}

std::vector<Method> costStages(const std::string& features, const cv::Size& size) {
  const auto detection = [=](const std::string& name, int most) -> Method {
    return {name, spec(most), 1, [=](const std::vector<Scene>&) -> Call {
              const std::shared_ptr<const core::Detector> detector = createDetector(features, most);
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
