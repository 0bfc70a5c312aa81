#include "corrsel/features/extractor.h"

#include <future>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <utility>

#include "base/parallel.h"
#include "base/stopwatch.h"
#include "features/descriptors/descriptor.h"
#include "features/detectors/detector.h"
#include "features/parts/feature_list.h"
#include "features/parts/grey_image.h"
#include "features/parts/image_options.h"
#include "features/parts/place_mask.h"
#include "features/parts/visible_area.h"

namespace corrsel::core {
FeatureExtractor::FeatureExtractor(std::string name, std::unique_ptr<Detector> detector,
                                   std::unique_ptr<Descriptor> descriptor, const ImageOptions& image)
    : name_(std::move(name)),
      detector_(std::move(detector)),
      descriptor_(std::move(descriptor)),
      image_(std::make_unique<const ImageOptions>(image)) {
  if (descriptor_ == nullptr && !detector_->describesKeypoints()) {
    throw std::invalid_argument("features '" + name_ + "': the detector " + detector_->name() +
                                " does not describe its keypoints; needed: a descriptor");
  }
}

FeatureExtractor::~FeatureExtractor() = default;

Features FeatureExtractor::extract(const cv::Mat& image, int threads, const FeatureRegion& region) const {
  return find(image, threads, region, true);
}

Features FeatureExtractor::detect(const cv::Mat& image, int threads, const FeatureRegion& region) const {
  return find(image, threads, region, false);
}

Features FeatureExtractor::find(const cv::Mat& image, int threads, const FeatureRegion& region,
                                bool describe) const {
  Features features;
  features.image_size = image.size();
  Stopwatch watch;
  checkImage(image);
  const cv::Rect area = visibleArea(region, image.size());
  DetectionRequest request;
  const DetectorOptions& options = detector_->options();
  GreyBuffer& buffer = request.workspace.part<GreyBuffer>();
  request.image = equalized(toGrey(image(area), options.max_megapixels, buffer), *image_, buffer);
  request.threads = threads;
  request.describe = describe && descriptor_ == nullptr;
  std::vector<ScaleLevel> levels;
  if (describe) request.levels = &levels;
  const AreaTransform to_whole(request.image.size(), area);
  // A mask that allows the whole area is left out, since masks cost OpenCV's detectors time.
  if (!region.mask.empty() && cv::countNonZero(region.mask(area)) < area.area()) {
    request.mask = PlaceMask(region.mask, to_whole);
  }
  detector_->detect(request, features);
  keepStrongest(options.max_features, options.spread, request.image.size(), features);
  features.detect_seconds = watch.restart();
  if (describe && descriptor_ != nullptr) {
    if (levels.empty()) {
      descriptor_->describe(request.image, threads, request.workspace, features);
    } else {
      descriptor_->describeOn(levels, request.image, threads, request.workspace, features);
    }
    features.describe_seconds = watch.seconds();
  }
  to_whole.apply(features);
  return features;
}

cv::Size FeatureExtractor::searchedSize(const cv::Size& image) const {
  return reducedSize(image, detector_->options().max_megapixels);
}

std::vector<std::pair<std::string, const OptionSet*>> FeatureExtractor::options() const {
  std::vector<std::pair<std::string, const OptionSet*>> result = {{detector_->name(), &detector_->options()}};
  if (descriptor_ != nullptr) result.emplace_back(descriptor_->name(), &descriptor_->options());
  result.emplace_back(kImageOptions, image_.get());
  return result;
}

std::pair<Features, Features> extractPair(const FeatureExtractor& extractor, const cv::Mat& left,
                                          const cv::Mat& right, int threads, const FeatureRegion& left_region,
                                          const FeatureRegion& right_region) {
  if (threads <= 1)
    return {extractor.extract(left, 1, left_region), extractor.extract(right, 1, right_region)};
  const int each = threads / 2;
  Features first, second;
  Crew crew;
  std::future<void> other = crew.start([&] { second = extractor.extract(right, each, right_region); });
  first = extractor.extract(left, threads - each, left_region);
  other.get();
  return {std::move(first), std::move(second)};
}

}  // namespace corrsel::core
